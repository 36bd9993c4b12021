#include <algorithm>
#include <cmath>

#include "qerr/core/error.hpp"
#include "qerr/kinematics/coordinates.hpp"
#include "report/analysis/effects.hpp"
#include "report/fitted_table.hpp"
#include "report/formats.hpp"
#include "report/text_table.hpp"
#include "report/wrapped_text.hpp"

namespace qerr {

namespace {

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

/// Whether the encoder's share is the largest, or equal to it in what is printed.
std::vector<bool> largest_of(const std::vector<double>& shares) {
  const double largest = *std::max_element(shares.begin(), shares.end());
  std::vector<bool> all;
  for (const double share : shares) all.push_back(share > 0 && percent(share) == percent(largest));
  return all;
}

/// Every encoder with its share as a bar; the largest is marked.
std::string encoder_table(const Analysis& a, const Style& style) {
  const std::vector<double> budget = encoder_budget(a);
  const std::vector<bool> largest = largest_of(budget);
  const auto first = std::count(largest.begin(), largest.end(), true);
  std::vector<std::vector<std::string>> rows{{"encoder", "resolution", "worst case", "sigma", "share"}};
  for (std::size_t i = 0; i < budget.size(); ++i) {
    const IndependentJoint& joint = a.spec.model.chain.independent[i];
    const std::string unit = joint.prismatic() ? "m" : "rad";
    const auto row = static_cast<Eigen::Index>(i);
    rows.push_back({escaped(joint.name, 28), readable(a.resolutions[row], unit),
                    readable(a.joints.worst_case[row], unit), readable(a.joints.sigma[row], unit),
                    percent(budget[i])});
  }
  const std::string text = aligned(rows), mark = first == 1 ? "  <- first" : "  <- equal";
  std::size_t table_width = 0;
  for (std::size_t at = 0, end; at < text.size(); at = end + 1) {
    end = text.find('\n', at);
    table_width = std::max(table_width, display_width(text.substr(at, end - at)));
  }
  const std::size_t beside = table_width + 2 + mark.size();
  const int bar_width = beside + 3 > style.width ? 0 : std::min(12, static_cast<int>(style.width - beside));
  std::string out;
  std::size_t at = 0;
  for (std::size_t i = 0; at < text.size(); ++i) {
    const std::size_t end = text.find('\n', at);
    std::string line = text.substr(at, end - at);
    at = end + 1;
    const std::string share = i > 0 && bar_width > 0 ? bar(budget[i - 1], bar_width) : "";
    if (!share.empty()) line += "  " + share;
    if (i > 0 && largest[i - 1] && budget.size() > 1) line = painted(line + mark, Paint::yellow, style);
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

std::string of_filter(const NamedFilter& f) { return escaped(f.name, 40) + ": " + norm_text(f); }

/// A statistic in the unit of the row.
std::vector<std::string> cells(const Statistic& s, const PrefixedUnit& unit) {
  return {readable_number(cleaned(s.p50) / unit.factor), readable_number(cleaned(s.max) / unit.factor)};
}

/// A coordinate: its unit, and median and maximum of sigma, of sigma in motion, of the worst case.
std::vector<std::string> summary_row(Coordinate c, const std::string& si, const Statistic* sigma,
                                     const Statistic* in_motion, bool motion_column, const Statistic& worst) {
  const PrefixedUnit unit = prefixed(worst.max, si);
  std::vector<std::string> row{std::string(info(c).name), unit.unit};
  const auto add = [&](const Statistic* s) {
    const std::vector<std::string> two = s ? cells(*s, unit) : std::vector<std::string>{"-", "-"};
    row.insert(row.end(), two.begin(), two.end());
  };
  add(sigma);
  if (motion_column) add(in_motion);
  add(&worst);
  return row;
}

/// The largest rigorous bounds that differ in print from the largest linear ones.
std::string rigorous_note(const Analysis& a, const Style& style) {
  const std::vector<Coordinate> coordinates = coordinates_and_lengths(a.spec.model);
  std::vector<std::string> differing;
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    const CoordinateStatistics& c = a.workspace.coordinates[i];
    const std::string unit(info(coordinates[i]).unit);
    const std::string text = readable(cleaned(c.worst_case_rigorous.max), unit);
    if (std::isfinite(c.worst_case_rigorous.max) && text != readable(cleaned(c.worst_case.max), unit))
      differing.push_back(std::string(info(coordinates[i]).name) + ' ' + text);
  }
  if (differing.empty()) return "";
  return wrapped("with the linearization remainder (rigorous) at most " + listed(differing), style.width,
                 "  ");
}

/// Median and maximum of every signal: one row a coordinate, one block a signal.
std::string summary_table(const Analysis& a, const Style& style) {
  const std::vector<Coordinate> coordinates = coordinates_and_lengths(a.spec.model);
  const Workspace& w = a.workspace;
  bool motion = false;
  for (std::size_t f = 0; f < a.spec.filters.size(); ++f) motion = motion || is_known(a.noise_in_motion, f);
  std::vector<std::string> header{"", "", "sigma median", "sigma max"};
  if (motion) header.insert(header.end(), {"in motion median", "in motion max"});
  header.insert(header.end(), {"worst median", "worst max"});
  std::vector<std::vector<std::string>> rows{header};
  for (std::size_t i = 0; i < coordinates.size(); ++i)
    rows.push_back(summary_row(coordinates[i], std::string(info(coordinates[i]).unit),
                               &w.coordinates[i].sigma, nullptr, motion, w.coordinates[i].worst_case));
  for (std::size_t f = 0; f < a.spec.filters.size(); ++f)
    for (std::size_t i = 0; i < coordinates.size(); ++i) {
      const DerivativeStatistics& d = w.derivatives[f][i];
      rows.push_back(summary_row(coordinates[i],
                                 derivative_unit(coordinates[i], a.spec.filters[f].filter.derivative),
                                 d.sigma ? &*d.sigma : nullptr,
                                 d.sigma_in_motion ? &*d.sigma_in_motion : nullptr, motion, d.worst_case));
    }
  const std::string text = fitted_table(rows, style.width, "    ");
  std::string out;
  std::size_t at = 0, line = 0;
  const auto lines = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  const std::size_t titles = lines - (rows.size() - 1);
  for (; at < text.size(); ++line) {
    if (line >= titles && (line - titles) % coordinates.size() == 0) {
      const std::size_t block = (line - titles) / coordinates.size();
      out +=
          wrapped(block == 0 ? "position" : of_filter(a.spec.filters[block - 1]), style.width, "    ", "  ");
    }
    const std::size_t end = text.find('\n', at);
    out += text.substr(at, end - at + 1);
    at = end + 1;
  }
  return out;
}

std::string summary(const Analysis& a, const Style& style) {
  std::string notes = "sigma: independent pseudo-quantization noise (IPQN)";
  if (has_effects(a)) notes += " and effects";
  if (a.spec.motion && !a.spec.filters.empty()) notes += "; in motion: encoders move as in `motion:`";
  return heading("Tip, estimate minus true, over the configurations", style) + summary_table(a, style) +
         rigorous_note(a, style) + wrapped(notes + "; all statistics: --details", style.width, "  ");
}

std::string details(const Analysis& a, const Style& style) {
  std::string out =
      heading("Position of the tip, estimate minus true, over the configurations", style) + position_table(a);
  for (std::size_t f = 0; f < a.spec.filters.size(); ++f)
    out += heading("Filter '" + escaped(a.spec.filters[f].name, 40) + "': " + norm_text(a.spec.filters[f]),
                   style) +
           derivative_table(a, f);
  if (a.spec.motion && !a.spec.filters.empty())
    out += '\n' + wrapped(
                      "sigma in motion: encoders move as in `motion:`, Jacobians are those of the "
                      "configurations",
                      style.width, "  ");
  return out;
}

}  // namespace

std::string to_table(const Analysis& a, const Style& style) {
  const Chain& chain = a.spec.model.chain;
  const std::string robot = "robot '" + escaped(a.spec.robot_name, 60) + "', " + escaped(chain.base, 60) +
                            " -> " + escaped(chain.tip, 60);
  std::string out = painted("qerr analyze", Paint::bold, style) +
                    wrapped("qerr analyze " + robot, style.width, "  ", "").substr(12) +
                    counted(chain.independent.size(), "encoder") + ", " + std::to_string(a.workspace.count) +
                    ' ' + name_of(a.spec.configurations.method) +
                    (a.workspace.count == 1 ? " configuration\n" : " configurations\n");
  out += heading(
             a.spec.model.along_motion
                 ? "Encoders: error at the joint with the effects, share of the encoders' variance at the tip"
             : has_effects(a) ? "Encoders and effects: error at the joint, share of the tip's variance"
                              : "Encoders: error at the joint, share of the tip's variance, first to upgrade",
             style) +
         encoder_table(a, style);
  if (!a.effects.empty())
    out +=
        heading("Effects: errors that they add at the joint", style) + effect_table(a.spec, a.effects, style);
  return out + (style.details ? details(a, style) : summary(a, style));
}

}  // namespace qerr
