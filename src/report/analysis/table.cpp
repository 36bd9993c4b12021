#include <algorithm>
#include <cmath>

#include "qerr/core/error.hpp"
#include "qerr/kinematics/coordinates.hpp"
#include "report/analysis/effects.hpp"
#include "report/formats.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

constexpr int bar_width = 12;

std::string name_of(SamplingMethod m) {
  switch (m) {
    case SamplingMethod::sobol:
      return "Sobol";
    case SamplingMethod::random:
      return "random";
    case SamplingMethod::grid:
      return "grid";
    case SamplingMethod::list:
      return "listed";
  }
  return {};
}

/// Every encoder with its share as a bar; the largest is marked.
std::string encoder_table(const Analysis& a, const Style& style) {
  const std::vector<double> budget = encoder_budget(a);
  const auto largest =
      static_cast<std::size_t>(std::max_element(budget.begin(), budget.end()) - budget.begin());
  std::vector<std::vector<std::string>> rows{{"encoder", "resolution", "worst case", "sigma", "share"}};
  for (std::size_t i = 0; i < budget.size(); ++i) {
    const IndependentJoint& joint = a.spec.model.chain.independent[i];
    const std::string unit = joint.prismatic() ? "m" : "rad";
    const auto row = static_cast<Eigen::Index>(i);
    rows.push_back({escaped(joint.name, 40), readable(a.resolutions[static_cast<Eigen::Index>(i)], unit),
                    readable(a.joints.worst_case[row], unit), readable(a.joints.sigma[row], unit),
                    percent(budget[i])});
  }
  const std::string text = aligned(rows);
  std::string out;
  std::size_t at = 0;
  for (std::size_t i = 0; at < text.size(); ++i) {
    const std::size_t end = text.find('\n', at);
    std::string line = text.substr(at, end - at);
    at = end + 1;
    if (i > 0) line += "  " + bar(budget[i - 1], bar_width);
    if (i == largest + 1 && budget[largest] > 0 && budget.size() > 1)
      line = painted(line + "  <- first", Paint::yellow, style);
    out += line + '\n';
  }
  return out;
}

/// 0 for rounding errors of sines and cosines: no length, angle or derivative of one is this small.
double cleaned(double value) { return std::abs(value) < 1e-18 ? 0 : value; }

/// The statistics that tables show: percentiles, then the maximum.
std::vector<StatisticKind> columns() {
  std::vector<StatisticKind> list;
  for (const StatisticKind& kind : statistic_kinds())
    if (!kind.heading.empty()) list.push_back(kind);
  std::stable_partition(list.begin(), list.end(), [](const auto& kind) { return kind.percentile >= 0; });
  return list;
}

std::vector<std::string> headings() {
  std::vector<std::string> row{""};
  for (const StatisticKind& kind : columns()) row.emplace_back(kind.heading);
  return row;
}

std::vector<std::string> figures(const std::string& label, const Statistic& s, const std::string& unit) {
  std::vector<std::string> row{label};
  for (const StatisticKind& kind : columns()) row.push_back(readable(cleaned(s.*kind.value), unit));
  return row;
}

bool has_effects(const Analysis& a) { return !a.spec.model.sources.empty() || a.spec.model.along_motion; }

const char* sigma_label(const Analysis& a) {
  return has_effects(a) ? "  sigma (IPQN, effects)" : "  sigma (IPQN)";
}

std::string position_table(const Analysis& a) {
  const std::vector<Coordinate> coordinates = coordinates_and_lengths(a.spec.model);
  std::vector<std::vector<std::string>> rows{headings()};
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    const CoordinateStatistics& c = a.workspace.coordinates[i];
    const std::string name(info(coordinates[i]).name), unit(info(coordinates[i]).unit);
    rows.push_back(figures(name + sigma_label(a), c.sigma, unit));
    rows.push_back(figures(name + "  worst case", c.worst_case, unit));
    if (std::isfinite(c.worst_case_rigorous.min))
      rows.push_back(figures(name + "  worst case, rigorous", c.worst_case_rigorous, unit));
  }
  return aligned(rows);
}

std::string derivative_table(const Analysis& a, std::size_t f) {
  const std::vector<Coordinate> coordinates = coordinates_and_lengths(a.spec.model);
  std::vector<std::vector<std::string>> rows{headings()};
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    const Coordinate c = coordinates[i];
    const std::string unit = derivative_unit(c, a.spec.filters[f].filter.derivative);
    if (const auto& sigma = a.workspace.derivatives[f][i].sigma)
      rows.push_back(figures(std::string(info(c).name) + sigma_label(a), *sigma, unit));
    else
      rows.push_back({std::string(info(c).name) + "  sigma: not known"});
    if (const auto& moving = a.workspace.derivatives[f][i].sigma_in_motion)
      rows.push_back(figures(std::string(info(c).name) + "  sigma in motion", *moving, unit));
    rows.push_back(
        figures(std::string(info(c).name) + "  worst case", a.workspace.derivatives[f][i].worst_case, unit));
  }
  return aligned(rows);
}

std::string norm_text(const NamedFilter& f) {
  const std::string unit = f.filter.derivative == 0   ? ""
                           : f.filter.derivative == 1 ? "/s"
                                                      : "/s^" + std::to_string(f.filter.derivative);
  return "H2 norm " + significant(f.norms.h2, 5) + unit + ", l1 norm " + significant(f.norms.l1.upper, 5) +
         unit + ", " + readable(1 / f.filter.sample_rate, "s") + " a sample";
}

}  // namespace

std::string to_table(const Analysis& a, const Style& style) {
  const Chain& chain = a.spec.model.chain;
  std::string out = painted("qerr analyze", Paint::bold, style) + "  robot '" +
                    escaped(a.spec.robot_name, 60) + "', " + escaped(chain.base, 60) + " -> " +
                    escaped(chain.tip, 60) + "\n" + counted(chain.independent.size(), "encoder") + ", " +
                    std::to_string(a.workspace.count) + " " + name_of(a.spec.configurations.method) +
                    (a.workspace.count == 1 ? " configuration\n" : " configurations\n");
  out += heading(
             a.spec.model.along_motion
                 ? "Encoders: error at the joint with the effects, share of the encoders' variance at the tip"
             : has_effects(a) ? "Encoders and effects: error at the joint, share of the tip's variance"
                              : "Encoders: error at the joint, share of the tip's variance, first to upgrade",
             style) +
         encoder_table(a, style);
  if (!a.effects.empty())
    out += heading("Effects: errors that they add at the joint", style) + effect_table(a.spec, a.effects);
  out +=
      heading("Position of the tip, estimate minus true, over the configurations", style) + position_table(a);
  for (std::size_t f = 0; f < a.spec.filters.size(); ++f)
    out += heading("Filter '" + escaped(a.spec.filters[f].name, 60) + "': " + norm_text(a.spec.filters[f]),
                   style) +
           derivative_table(a, f);
  if (a.spec.motion && !a.spec.filters.empty())
    out += "\n  sigma in motion: encoders move as in `motion:`, Jacobians are those of the configurations\n";
  return out;
}

}  // namespace qerr
