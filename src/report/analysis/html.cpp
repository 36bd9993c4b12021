#include <algorithm>
#include <array>
#include <cmath>

#include "bound/batched_error.hpp"
#include "bound/histogram.hpp"
#include "core/parallel.hpp"
#include "core/random.hpp"
#include "core/text.hpp"
#include "qerr/kinematics/coordinates.hpp"
#include "report/analysis/figures.hpp"
#include "report/analysis/tables.hpp"
#include "report/formats.hpp"
#include "report/page/page.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

/// At most so many: the standard error of a percentage is then below 0.3 %, half a pixel.
constexpr std::uint64_t most_sampled = std::uint64_t{1} << 15;

Configurations reduced(const Configurations& all) {
  const std::uint64_t count = size(all);
  if (count <= most_sampled) return all;
  Configurations some = all;
  if (all.method == SamplingMethod::sobol || all.method == SamplingMethod::random) {
    some.count = most_sampled;
    return some;
  }
  some.method = SamplingMethod::list;
  some.points.clear();
  const double part = static_cast<double>(count) / most_sampled;
  for (std::uint64_t i = 0; i < most_sampled; ++i) {
    const double at = part * (static_cast<double>(i) + unit_interval(stream_seed(all.seed, "page", i)));
    some.points.emplace_back(draw(all, std::min(static_cast<std::uint64_t>(at), count - 1), 1).col(0));
  }
  return some;
}

/// Receives batches from any thread; each writes to places of its own.
class SampleCollector {
 public:
  SampleCollector(const Analysis& a, std::size_t count) : a_(a), filters_(filter_norms(a.spec)) {
    for_each_figure(a, [&](const FigureName& name, const Statistic&) { figures_.push_back(name.figure); });
    sample_.of = a.workspace.count;
    sample_.q.resize(count);
    sample_.tips.resize(count);
    sample_.trace.resize(count);
    sample_.worst.assign(a.workspace.coordinates.size(), std::vector<double>(count));
    sample_.distributions.assign(figures_.size(), std::vector<double>(count));
  }

  void add(const ConfigurationBatch& batch) {
    const Chain& chain = a_.spec.model.chain;
    std::vector<FigureColumn> columns;
    for (const Figure& f : figures_) columns.push_back(figure_column(f, filters_, batch.layout));
    for (std::size_t i = 0; i < batch.count; ++i) {
      const std::size_t to = static_cast<std::size_t>(batch.first) + i;
      const auto figure = [&](std::size_t f) { return batch.figures[f * batch_size + i]; };
      sample_.q[to] = configuration_of(batch, i, chain);
      sample_.tips[to] = forward_kinematics(chain, sample_.q[to]).translation();
      sample_.trace[to] = figure(batch.layout.trace);
      for (std::size_t c = 0; c < sample_.worst.size(); ++c)
        sample_.worst[c][to] = figure(batch.layout.worst_case + c);
      for (std::size_t f = 0; f < columns.size(); ++f)
        sample_.distributions[f][to] = columns[f].factor * figure(columns[f].figure);
    }
  }

  ConfigurationSample sorted() {
    parallel_for(sample_.distributions.size(), 0,
                 [&](std::size_t f) { std::ranges::sort(sample_.distributions[f]); });
    return std::move(sample_);
  }

 private:
  const Analysis& a_;
  std::vector<Norms> filters_;
  std::vector<Figure> figures_;
  ConfigurationSample sample_;
};

/// Configurations to draw, equal for any number of threads: the first ones of Sobol's sequence and of random
/// points, which are spread like all of them; of a grid and of a list one at random of each of equally many
/// parts.
ConfigurationSample configuration_sample(const Analysis& a) {
  const Configurations some = reduced(a.spec.configurations);
  const auto count = static_cast<std::size_t>(size(some));
  SampleCollector collector(a, count);
  WorkspaceOptions options;
  options.noise_in_motion = a.noise_in_motion;
  options.visit = [&](const ConfigurationBatch& batch) { collector.add(batch); };
  workspace(a.spec.model, filter_norms(a.spec), some, options);
  return collector.sorted();
}

/// "" of a complete sample, else how many of the configurations it has.
std::string sampled_note(const ConfigurationSample& s) {
  return s.complete() ? "" : ", drawn from " + std::to_string(s.q.size()) + " of them";
}

template <class Shares>
page::Bars bars_of(const Analysis& a, const std::string& title, const Shares& shares) {
  page::Bars bars{title,
                  "Share of each encoder; the shares add up to 100 % unless effects without an encoder "
                  "contribute.",
                  {}};
  const auto& joints = a.spec.model.chain.independent;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const double share = shares[i];
    bars.bars.push_back({joints[i].name, share, percent(share)});
  }
  return bars;
}

/// Each encoder's share: of the tip's position (`encoder_budget`), and of the variance and of the worst case
/// of each coordinate, one to be chosen.
std::string budget_figures(const Analysis& a) {
  std::vector<std::pair<std::string, std::string>> all;
  const std::vector<double> budget = encoder_budget(a);
  const Eigen::Map<const Eigen::VectorXd> mean(budget.data(), std::ssize(budget));
  if (mean.size() > 0)
    all.emplace_back("tip, variance", figure(bars_of(a, "Share of the tip's mean variance", mean)));
  const std::vector<Signal> coordinates = all_signals(a.spec.model);
  for (std::size_t i = 0; i < a.workspace.coordinates.size(); ++i) {
    const CoordinateStatistics& c = a.workspace.coordinates[i];
    const std::string& name = coordinates[i].name;
    if (c.share.size() > 0)
      all.emplace_back(name + ", variance", figure(bars_of(a, "Share of the variance of " + name, c.share)));
    if (c.share_worst_case.size() > 0)
      all.emplace_back(name + ", worst case",
                       figure(bars_of(a, "Share of the worst case of " + name, c.share_worst_case)));
  }
  const std::string filters =
      a.spec.filters.empty() ? ""
      : a.spec.model.sources.empty() && !a.spec.model.along_motion
          ? "<p>Behind each filter the shares are the same: its norm multiplies every encoder's part.</p>"
          : "<p>The shares are those of the unfiltered position: behind a filter the effects of the spec "
            "have other shares, according to their spectra.</p>";
  if (all.empty()) return "<p>Of the spec's coordinates no shares are computed.</p>";
  return page::choice("Coordinate and bound", all) + filters;
}

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
  const auto value = [&](std::uint64_t rank) { return sorted[rank]; };
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

/// The distribution of every bound, one quantity to be chosen, with limits required of them and proven
/// maxima.
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

constexpr std::array<const char*, 3> axis_names{"x", "y", "z"};

using Plane = std::array<Eigen::Index, 2>;

/// The axes of the base frame that span each picture: all three planes, or that of a workspace that is flat.
std::vector<Plane> planes_of(const Eigen::Vector3d& extent) {
  constexpr double flat = 0.5;  // of the next smaller extent: a side view of it would be a strip
  Eigen::Index least = 0;
  extent.minCoeff(&least);
  const Eigen::Index a = (least + 1) % 3, b = (least + 2) % 3;
  if (extent[least] > flat * std::min(extent[a], extent[b])) return {{0, 2}, {0, 1}, {1, 2}};
  return {{std::min(a, b), std::max(a, b)}};
}

struct TipGrid {
  Plane axes;
  std::array<std::pair<double, double>, 2> span;
  std::array<std::size_t, 2> cells;
  std::vector<std::size_t> cell_of;  ///< [configuration]
};

/// About six configurations a cell, so that few cells inside the workspace are empty, and a hundred by a
/// hundred cells at most: a cell is then three pixels.
TipGrid tip_grid(const ConfigurationSample& sample, const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                 const Plane& plane) {
  constexpr double configurations_a_cell = 6, most_cells = 1e4;
  TipGrid g{plane, {}, {}, {}};
  // A tip that moves by its rounding errors alone rests.
  const double extent = (high - low).maxCoeff(),
               distance = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff()),
               longest = extent > 1e-9 * (1 + distance) ? extent : 1;
  const double cells =
      std::clamp(static_cast<double>(sample.tips.size()) / configurations_a_cell, 16.0, most_cells);
  for (std::size_t k = 0; k < 2; ++k) {
    const Eigen::Index axis = g.axes[k];
    // An axis on which the tip rests has a row of cells of a hundredth of the other's length.
    const double margin = std::max(0.0, 0.005 * longest - 0.5 * (high - low)[axis]);
    g.span[k] = {low[axis] - margin, high[axis] + margin};
  }
  const double width = g.span[0].second - g.span[0].first, height = g.span[1].second - g.span[1].first;
  const double side = std::sqrt(width * height / cells);
  g.cells = {static_cast<std::size_t>(std::clamp(std::ceil(width / side), 1.0, 100.0)),
             static_cast<std::size_t>(std::clamp(std::ceil(height / side), 1.0, 100.0))};
  for (const Eigen::Vector3d& tip : sample.tips) {
    std::array<std::size_t, 2> at{};
    for (std::size_t k = 0; k < 2; ++k) {
      const double part = (tip[g.axes[k]] - g.span[k].first) / (g.span[k].second - g.span[k].first);
      at[k] = std::min(static_cast<std::size_t>(part * static_cast<double>(g.cells[k])), g.cells[k] - 1);
    }
    g.cell_of.push_back(at[1] * g.cells[0] + at[0]);
  }
  return g;
}

std::string worst_case_map(const TipGrid& g, const std::vector<double>& values, const Signal& c) {
  const std::string x = axis_names[g.axes[0]], y = axis_names[g.axes[1]];
  page::HeatMap map{"Worst case of " + c.name + " over the workspace, " + x + y,
                    "Largest worst case among the configurations with the tip in a cell.",
                    {x, "m", false, false},
                    {y, "m", false, false},
                    {"worst case of " + c.name, c.unit},
                    g.span[0],
                    g.span[1],
                    g.cells[0],
                    g.cells[1],
                    std::vector<double>(g.cells[0] * g.cells[1], NAN),
                    true};
  for (std::size_t i = 0; i < values.size(); ++i) {
    double& cell = map.cells[g.cell_of[i]];
    if (!(cell >= values[i])) cell = values[i];
  }
  return figure(map);
}

/// The largest worst case of each coordinate by the position of the tip, one coordinate to be chosen.
std::string workspace_figures(const Analysis& a, const ConfigurationSample& sample) {
  if (sample.tips.empty()) return "<p>Without a configuration there is no workspace.</p>";
  Eigen::Vector3d low = Eigen::Vector3d::Constant(INFINITY), high = -low;
  for (const Eigen::Vector3d& tip : sample.tips) low = low.cwiseMin(tip), high = high.cwiseMax(tip);
  std::vector<TipGrid> grids;
  for (const Plane& plane : planes_of(high - low)) grids.push_back(tip_grid(sample, low, high, plane));
  const std::vector<Signal> coordinates = all_signals(a.spec.model);
  std::vector<std::pair<std::string, std::string>> all;
  for (std::size_t c = 0; c < sample.worst.size(); ++c) {
    if (coordinates[c].kind && !coordinates[c].kind->of_chain)
      continue;  // of a joint or a loop, not of a place
    std::string maps;
    for (const TipGrid& grid : grids) maps += worst_case_map(grid, sample.worst[c], coordinates[c]);
    all.emplace_back(coordinates[c].name, "<div class=\"figures\">" + maps + "</div>");
  }
  if (all.empty()) return "<p>The spec has no coordinate of the tip.</p>";
  return "<p>By the position of the tip in the base frame, in each plane of it: the largest worst case "
         "of the configurations in a cell, of " +
         std::to_string(sample.of) + " configurations" + sampled_note(sample) +
         ". Without colour: no configuration.</p>" + page::choice("Coordinate", all);
}

/// Standard deviation of the position: of |(x, y, z)| [m]; empty without all three.
std::optional<double> position_sigma(const Analysis& a, const Eigen::MatrixXd& covariance) {
  const std::vector<Coordinate>& all = a.spec.model.coordinates;
  double sum = 0;
  int found = 0;
  for (std::size_t i = 0; i < all.size() && static_cast<Eigen::Index>(i) < covariance.rows(); ++i)
    if (is_position(all[i])) sum += covariance(i, i), ++found;
  return found == 3 && std::isfinite(sum) ? std::optional(std::sqrt(sum)) : std::nullopt;
}

/// The error of xyz, or the first figures of the tip if it has no such three.
std::string tip_sentence(const Analysis& a) {
  std::string text = "Over " + counted(a.workspace.count, "configuration") + " the tip's ";
  const auto mean = position_sigma(a, a.workspace.mean_covariance),
             most = position_sigma(a, a.workspace.covariance_at_largest);
  if (mean && most)
    return text + "position xyz has a sigma of " + readable(*mean, "m") + " rms, and of " +
           readable(*most, "m") + " where it is largest";
  bool said = false;
  for_each_figure(a, [&](const FigureName& name, const Statistic& s) {
    if (said || name.bound != "worst_case") return;
    said = true;
    text += std::string(name.coordinate) + " is off by at most " + readable(s.max, name.shown_unit) +
            ", at the median by " + readable(s.p50, name.shown_unit);
  });
  return text;
}

/// The first requirement that is not met, else the first.
std::string requirement_sentence(const Spec& spec, const std::vector<RequirementResult>& results) {
  if (results.empty()) return "";
  std::size_t i = 0;
  for (std::size_t k = results.size(); k-- > 0;)
    if (!results[k].met) i = k;
  std::string kept = margin_text(spec.requirements[i], results[i]);
  if (!kept.empty())
    kept = kept[0] == '-' ? ", beyond its limit by " + kept.substr(1) : ", a margin of " + kept;
  return "; " + page::isolated(limited(spec.requirements[i])) + " is " +
         (results[i].met         ? "met"
          : results[i].undecided ? "not proven"
                                 : "not met") +
         " with " + readable(results[i].value, spec.requirements[i].unit) + kept;
}

/// The error of the tip, the first requirement, and the encoder to improve.
std::string answer(const Analysis& a, const std::optional<std::vector<RequirementResult>>& results) {
  std::string text = tip_sentence(a) + (results ? requirement_sentence(a.spec, *results) : "");
  const std::vector<double> budget = encoder_budget(a);
  const auto largest = std::ranges::max_element(budget);
  if (largest != budget.end() && *largest > 0)
    text += "; the first encoder to upgrade is that of " +
            page::isolated(a.spec.model.chain.independent[largest - budget.begin()].name) + ", with " +
            percent(*largest) + " of the variance";
  return text + '.';
}

/// As requirements name it; the filter's name keeps its writing direction to itself.
std::string isolated_quantity(const FigureName& name) {
  const std::string quantity = name.quantity();
  return name.filter.empty() ? quantity : page::isolated(name.filter) + quantity.substr(name.filter.size());
}

std::string summary(const Analysis& a) {
  TableRows rows;
  for_each_figure(a, [&](const FigureName& name, const Statistic& s) {
    const ProvenMaximum* proof = find_proof(a, name.figure);
    rows.push_back({isolated_quantity(name), readable(s.p50, name.shown_unit),
                    readable(s.p95, name.shown_unit), readable(s.p99, name.shown_unit),
                    readable(s.max, name.shown_unit),
                    proof ? readable(proof->upper, name.shown_unit) : "not asked for"});
  });
  return page::table({"quantity", "median", "p95", "p99", "max", "proven maximum"}, rows);
}

/// Torques, loops and walls of a spec with controllers; "" without.
std::string control_part(const Analysis& a) {
  std::string out;
  if (a.control)
    for (ControlTable& table : control_tables(a.spec, *a.control)) {
      if (!table.rows.empty())
        out += page::subtitle(table.title) + page::table(std::move(table.rows), "name");
      for (const std::string& note : table.notes) out += page::paragraph(note + '.');
    }
  return out;
}

std::optional<std::vector<RequirementResult>> verdicts_of(const Analysis& a) {
  try {
    return requirement_results(a);
  } catch (const Error&) {  // one that cannot be judged is no reason for no page
    return std::nullopt;
  }
}

}  // namespace

page::Page page_of(const Analysis& a) {
  const ConfigurationSample sample = configuration_sample(a);
  const auto results = verdicts_of(a);
  page::Page page{
      "Accuracy of " + a.spec.robot_name,
      answer(a, results),
      {{"The robot where its position is least certain, and where it is as usual", robot_figures(a, sample)},
       {"Error budget of the encoders", budget_figures(a)},
       {"Distribution over the configurations", distribution_figures(a, sample)},
       {"Error over the workspace", workspace_figures(a, sample)},
       {"All figures", summary(a)}},
      a.warnings};
  if (std::string control = control_part(a); !control.empty())
    page.sections.insert(page.sections.begin() + 1, {"Torques, loops and walls", std::move(control)});
  describe(page, a.spec, results);
  return page;
}

}  // namespace qerr
