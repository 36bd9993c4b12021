#include <cmath>

#include "report/analysis/figure_names.hpp"
#include "report/analysis/page/pictures.hpp"
#include "report/page/page.hpp"
#include "report/page/plot.hpp"

namespace qerr {

namespace {

/// The percentiles that reports show, from the smallest value to the largest.
page::Series series_of(const FigureName& name, const Statistic& s) {
  return {std::string(name.bound), {{s.min, 0}, {s.p50, 50}, {s.p95, 95}, {s.p99, 99}, {s.max, 100}}, true};
}

void add_markers(page::Plot& plot, const Analysis& a, const FigureName& name) {
  if (const ProvenMaximum* proof = find_proof(a, name.figure))
    plot.markers.push_back({"proven maximum of " + std::string(name.bound), proof->upper});
  for (const Requirement& r : a.spec.requirements)
    if (r.quantity == name.quantity()) plot.markers.push_back({"required: " + r.name(), r.limit});
}

}  // namespace

std::string distribution_figures(const Analysis& a) {
  std::vector<std::pair<std::string, std::string>> all;
  std::vector<page::Plot> plots;
  std::vector<std::string> names;
  for_each_figure(a, [&](const FigureName& name, const Statistic& s) {
    const std::string of =
        (name.filter.empty() ? std::string(name.signal) : name.filter) + ' ' + std::string(name.coordinate);
    if (names.empty() || names.back() != of) {
      names.push_back(of);
      plots.push_back({"Error of " + of,
                       "Percentage of the configurations whose error is at most the value on the abscissa: "
                       "smallest, median, 95 %, 99 %, largest.",
                       {"error", name.unit},
                       {"configurations", "%"},
                       {}});
    }
    plots.back().series.push_back(series_of(name, s));
    add_markers(plots.back(), a, name);
  });
  for (std::size_t i = 0; i < plots.size(); ++i) all.emplace_back(names[i], figure(plots[i]));
  return "<p>Percentage of the configurations with at most this error: smallest, median, 95 %, 99 % and "
         "largest, joined by straight lines.</p>" +
         page::choice("Quantity", all);
}

}  // namespace qerr
