#include <algorithm>
#include <cmath>

#include "bound/joined_tally.hpp"
#include "report/analysis/figure_names.hpp"
#include "report/analysis/page/pictures.hpp"
#include "report/page/page.hpp"
#include "report/page/plot.hpp"

namespace qerr {

namespace {

/// Percentages at which the curve is drawn, closer where reports have their percentiles.
std::vector<double> drawn_percentages() {
  std::vector<double> all{0, 0.5, 1, 2, 3};
  for (int p = 5; p < 95; p += 5) all.push_back(p);
  for (const double p : {95.0, 96.0, 97.0, 98.0, 99.0, 99.5, 100.0}) all.push_back(p);
  return all;
}

/// The distribution over the sample, with the figures of the report as marks; its ends are those of the
/// report.
page::Series series_of(const FigureName& name, const Statistic& s, const std::vector<double>& sorted) {
  page::Series series{std::string(name.bound), {}};
  const auto value = [&](std::uint64_t rank) { return sorted[static_cast<std::size_t>(rank)]; };
  for (const double p : drawn_percentages())
    series.points.emplace_back(p == 0     ? s.min
                               : p == 100 ? s.max
                                          : percentile(p / 100, sorted.size(), value),
                               p);
  series.marked = {{s.min, 0}, {s.p50, 50}, {s.p95, 95}, {s.p99, 99}, {s.max, 100}};
  return series;
}

void add_markers(page::Plot& plot, const Analysis& a, const FigureName& name) {
  if (const ProvenMaximum* proof = find_proof(a, name.figure))
    plot.markers.push_back({"proven maximum of " + std::string(name.bound), proof->upper});
  for (const Requirement& r : a.spec.requirements)
    if (r.quantity == name.quantity()) plot.markers.push_back({"required: " + r.name(), r.limit});
}

}  // namespace

std::string distribution_figures(const Analysis& a, const ConfigurationSample& sample) {
  std::vector<std::pair<std::string, std::string>> all;
  std::vector<page::Plot> plots;
  std::vector<std::string> names;
  std::size_t figure_index = 0;
  if (sample.q.empty()) return "<p>Without a configuration there is no distribution.</p>";
  for_each_figure(a, [&](const FigureName& name, const Statistic& s) {
    const std::string of =
        (name.filter.empty() ? std::string(name.signal) : name.filter) + ' ' + std::string(name.coordinate);
    if (names.empty() || names.back() != of) {
      names.push_back(of);
      plots.push_back(
          {"Error of " + of,
           "Percentage of the configurations whose error is at most the value on the abscissa; marks at "
           "the smallest, median, 95 %, 99 % and largest.",
           {"error", name.shown_unit},
           {"configurations", "%"},
           {}});
    }
    plots.back().series.push_back(series_of(name, s, sample.distributions[figure_index++]));
    add_markers(plots.back(), a, name);
  });
  for (std::size_t i = 0; i < plots.size(); ++i) all.emplace_back(names[i], figure(plots[i]));
  return "<p>Percentage of the " + std::to_string(sample.of) + " configurations with at most this error" +
         sampled_note(sample) + ". Marks: smallest, median, 95 %, 99 % and largest, of all.</p>" +
         page::choice("Quantity", all);
}

}  // namespace qerr
