#include <algorithm>
#include <array>
#include <cmath>

#include "core/text.hpp"
#include "kinematics/inverse_dynamics.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/kinematics/coordinates.hpp"
#include "report/analysis/effects.hpp"
#include "report/analysis/figures.hpp"
#include "report/analysis/tables.hpp"
#include "report/formats.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

bool has_effects(const Analysis& a) { return !a.spec.model.sources.empty() || a.spec.model.along_motion; }

/// `H2 norm 40.738/s, l1 norm 138.86/s, 1.00 ms a sample`.
std::string norm_text(const NamedFilter& f) {
  const std::string unit = f.filter.derivative == 0 ? "" : rate_unit(f.filter.derivative).substr(1);
  return "H2 norm " + significant(f.norms.h2, 5) + unit + ", l1 norm " + significant(f.norms.l1.upper, 5) +
         unit + ", " + readable(1 / f.filter.sample_rate, "s") + " a sample";
}

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

const char* sigma_label(const Analysis& a) {
  return has_effects(a) ? "  sigma (IPQN, effects)" : "  sigma (IPQN)";
}

/// @param group  of closed loops: `closed_torque`; "": of all other signals
std::string position_table(const Analysis& a, const std::string& group, const Style& style) {
  const std::vector<Signal> coordinates = all_signals(a.spec.model);
  TableRows rows{headings()};
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    const bool closed = is_closed(coordinates[i]);
    if ((closed ? coordinates[i].kind->group : "") != group) continue;
    const CoordinateStatistics& c = a.workspace.coordinates[i];
    const std::string name = closed ? coordinates[i].name.substr(group.size() + 1) : coordinates[i].name,
                      &unit = coordinates[i].unit;
    rows.push_back(figures(name + sigma_label(a), c.sigma, unit));
    rows.push_back(figures(name + "  worst case", c.worst_case, unit));
    if (!closed && std::isfinite(c.worst_case_rigorous.min))
      rows.push_back(figures(name + "  worst case, rigorous", c.worst_case_rigorous, unit));
  }
  return rows.size() > 1 ? fitted_table(rows, style.width) : "";
}

std::string derivative_table(const Analysis& a, std::size_t f, const Style& style) {
  const std::vector<Signal> coordinates = all_signals(a.spec.model);
  TableRows rows{headings()};
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    const Signal& c = coordinates[i];
    if (!is_filtered(a.spec.filters[f], c)) continue;
    const std::string unit = shown_unit(c.unit, a.spec.filters[f].filter);
    if (const auto& sigma = a.workspace.derivatives[f][i].sigma)
      rows.push_back(figures(c.name + sigma_label(a), *sigma, unit));
    else
      rows.push_back({c.name + "  sigma: not known"});
    if (const auto& alone = a.workspace.derivatives[f][i].sigma_quantization)
      rows.push_back(figures(c.name + "  sigma of quantization", *alone, unit));
    if (const auto& moving = a.workspace.derivatives[f][i].sigma_in_motion)
      rows.push_back(figures(c.name + "  sigma in motion", *moving, unit));
    rows.push_back(figures(c.name + "  worst case", a.workspace.derivatives[f][i].worst_case, unit));
  }
  return fitted_table(rows, style.width);
}

using Three = std::array<Coordinate, 3>;

/// Indices of three coordinates in the model; empty if one is missing.
std::optional<std::array<Eigen::Index, 3>> find_three(const OperationalModel& model, const Three& wanted) {
  std::array<Eigen::Index, 3> at{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto found = std::ranges::find(model.coordinates, wanted[i]);
    if (found == model.coordinates.end()) return std::nullopt;
    at[i] = found - model.coordinates.begin();
  }
  return at;
}

Eigen::Matrix3d block(const Eigen::MatrixXd& covariance, const std::array<Eigen::Index, 3>& at) {
  Eigen::Matrix3d three;
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t c = 0; c < 3; ++c) three(r, c) = covariance(at[r], at[c]);
  return three;
}

/// The ellipsoids of one sigma, in the axes of the analysis; "" without three coordinates of a kind.
std::string ellipsoid_tables(const Analysis& a, const Style& style) {
  const std::string axes = a.spec.model.frame == CoordinateFrame::tip ? "the tip" : "the base";
  std::string out;
  for (const TipEllipsoids& tip : tip_ellipsoids(a)) {
    TableRows rows{{"semi-axis", "sigma", "x", "y", "z"}};
    const auto add = [&](const std::string& where, const ErrorEllipsoid& e) {
      for (Eigen::Index i = 0; i < 3; ++i) {
        rows.push_back(
            {where + ' ' + std::to_string(i + 1), readable(e.semi_axes[i], std::string(tip.unit))});
        for (Eigen::Index c = 0; c < 3; ++c) rows.back().push_back(fixed_point(e.directions(c, i), 3));
      }
    };
    add("mean", tip.mean);
    add("largest", tip.at_largest);
    out += table_section(
        "Ellipsoid of one sigma of the " + std::string(tip.of) + ", directions in the axes of " + axes, rows,
        style);
  }
  if (!out.empty())
    out += wrapped(
        "mean: root mean square over the configurations; largest: where that of the position is largest",
        style.width, "  ");
  return out;
}

/// All statistics that tables show, one table a signal.
std::string detail_tables(const Analysis& a, const Style& style) {
  std::string out = heading("Position of the tip, estimate minus true, over the configurations", style) +
                    position_table(a, "", style);
  std::vector<std::string> groups;  // of closed loops
  for (const Signal& signal : all_signals(a.spec.model))
    if (is_closed(signal) && (groups.empty() || groups.back() != signal.kind->group))
      groups.emplace_back(signal.kind->group);
  for (const std::string& group : groups)
    out += heading("Loops closed: " + group + " due to errors", style) + position_table(a, group, style);
  out += ellipsoid_tables(a, style);
  for (std::size_t f = 0; f < a.spec.filters.size(); ++f)
    out += heading("Filter '" + escaped(a.spec.filters[f].name, 40) + "': " + norm_text(a.spec.filters[f]),
                   style) +
           derivative_table(a, f, style);
  if (a.spec.motion && !a.spec.filters.empty())
    out += '\n' + wrapped(
                      "sigma in motion: encoders move as in `motion:`, Jacobians are those of the "
                      "configurations",
                      style.width, "  ");
  return out;
}

std::string table_of(const Exceedance& e, const std::string& base, const Style& style) {
  std::string out =
      heading(shown(e.quantity) + " above " + readable(e.limit, e.unit) + ": " + std::to_string(e.above) +
                  " of " + std::to_string(e.count) + " configurations, " +
                  percent(static_cast<double>(e.above) / static_cast<double>(e.count)),
              style);
  if (e.above == 0) return out;
  TableRows rows{{"distance of the tip", "configurations", "above", "share"}};
  for (const Exceedance::Shell& s : e.by_distance)
    if (s.count > 0)
      rows.push_back({significant(s.from, 3) + " to " + significant(s.to, 3) + " m", std::to_string(s.count),
                      std::to_string(s.above),
                      percent(static_cast<double>(s.above) / static_cast<double>(s.count))});
  out += fitted_table(rows, style.width);
  std::string box = "distance: from the origin of " + escaped(base, 60) + "; above the limit the tip is at";
  const char* const names = "xyz";
  for (Eigen::Index i = 0; i < 3; ++i)
    box += std::string(i > 0 ? ", " : " ") + names[i] + ' ' + significant(e.lowest[i], 3) + " to " +
           significant(e.highest[i], 3) + " m";
  return out + wrapped(box, style.width, "  ");
}

/// Shares of the configurations above the limits that were asked for, by the distance of the tip.
std::string exceedance_tables(const Analysis& a, const Style& style) {
  std::string out;
  for (const Exceedance& e : a.exceedances) out += table_of(e, a.spec.model.chain.base, style);
  return out;
}

std::string name_of(SamplingMethod m) {
  return m == SamplingMethod::sobol    ? "Sobol"
         : m == SamplingMethod::random ? "random"
         : m == SamplingMethod::grid   ? "grid"
                                       : "listed";
}

/// Whether the encoder's share is the largest, or equal to it in what is printed.
std::vector<bool> largest_of(const std::vector<double>& shares) {
  const double largest = *std::ranges::max_element(shares);
  std::vector<bool> all;
  for (const double share : shares) all.push_back(share > 0 && percent(share) == percent(largest));
  return all;
}

/// Every encoder with its share as a bar; the largest is marked.
std::string encoder_table(const Analysis& a, const Style& style) {
  std::vector<double> budget = encoder_budget(a);
  budget.resize(a.spec.model.chain.independent.size());
  const std::vector<bool> largest = largest_of(budget);
  const auto first = std::ranges::count(largest, true);
  const bool of_tip = !a.spec.model.coordinates.empty();
  TableRows rows{{"encoder", "resolution", "worst case", "sigma"}};
  if (of_tip) rows.front().emplace_back("share");
  for (std::size_t i = 0; i < budget.size(); ++i) {
    const IndependentJoint& joint = a.spec.model.chain.independent[i];
    const std::string unit = joint.unit();
    rows.push_back({shortened(joint.name, 22), readable(a.resolutions[i], unit),
                    readable(a.joints.worst_case[i], unit), readable(a.joints.sigma[i], unit)});
    if (of_tip) rows.back().push_back(percent(budget[i]));
  }
  std::vector<std::string> lines = aligned_lines(rows);
  const std::string mark = first == 1 ? "  <- first" : "  <- equal";
  std::size_t table_width = 0;
  for (const std::string& line : lines) table_width = std::max(table_width, display_width(line));
  const std::size_t beside = table_width + 2 + mark.size();
  const int bar_width = beside + 3 > style.width ? 0 : std::min(12, static_cast<int>(style.width - beside));
  for (std::size_t i = 0; i < budget.size(); ++i) {
    std::string& line = lines[i + 1];
    const std::string share = bar_width > 0 ? bar(budget[i], bar_width) : "";
    if (!share.empty()) line += "  " + share;
    if (largest[i] && budget.size() > 1) line = painted(line + mark, Paint::yellow, style);
  }
  return joined(lines, "\n") + '\n';
}

/// By how much sigma falls if a share of the variance vanishes.
double fall_of_sigma(double share) { return 1 - std::sqrt(std::max(0.0, 1 - share)); }

std::vector<std::string> row_of(const std::string& name, const std::string& count,
                                const std::string& accuracy, const BudgetParts& p, bool effects) {
  std::vector<std::string> row{name, count, accuracy, percent(p.quantization), percent(p.accuracy)};
  if (effects) row.push_back(percent(p.effects));
  return row;
}

/// Table of what each encoder's resolution and accuracy contribute to the tip's variance; "" if no encoder
/// states an accuracy.
std::string accuracy_table(const Analysis& a, const Style& style) {
  if (!states_accuracy(a.spec)) return "";
  const std::vector<BudgetParts> parts = budget_parts(a);
  BudgetParts sum;
  for (const BudgetParts& p : parts) {
    sum.quantization += p.quantization;
    sum.accuracy += p.accuracy;
    sum.effects += p.effects;
  }
  const bool effects = sum.effects > 0;
  TableRows rows{{"encoder", "half a count", "accuracy", "resolution", "accuracy"}};
  rows[0][3] = "share of resolution";
  rows[0][4] = "share of accuracy";
  if (effects) rows[0].emplace_back("share of effects");
  for (std::size_t e = 0; e < parts.size(); ++e) {
    const IndependentJoint& joint = a.spec.model.chain.independent[e];
    const Encoder& encoder = a.spec.model.transmission.encoders[e];
    const double slow = encoder.accuracy + encoder.gear_accuracy;
    const std::string unit = joint.unit();
    rows.push_back(row_of(shortened(joint.name, 22), readable(0.5 * encoder.resolution, unit),
                          slow > 0 ? readable(slow, unit) : "", parts[e], effects));
  }
  rows.push_back(row_of("all", "", "", sum, effects));
  return table_section("Accuracy or resolution: where the tip's variance comes from", rows, style,
                       "without the accuracies sigma would be " + percent(fall_of_sigma(sum.accuracy)) +
                           " less, with infinitely fine counts " + percent(fall_of_sigma(sum.quantization)) +
                           " less");
}

/// The lines, each with its text at the end; below it where the line would be too wide.
std::string with_texts(const std::vector<std::string>& lines, const std::vector<std::string>& texts,
                       std::size_t width) {
  std::string out;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const bool beside = texts[i].empty() || display_width(lines[i]) + 2 + display_width(texts[i]) <= width;
    out += lines[i] + (beside && !texts[i].empty() ? "  " + texts[i] : "") + '\n';
    if (!beside) out += wrapped(texts[i], width, "      ");
  }
  return out;
}

/// Every effect, the errors that it adds at its joint, and its parameters.
std::string effect_table(const Spec& spec, const std::vector<EffectShare>& shares, const Style& style) {
  TableRows rows{{"effect", "joint", "mean", "worst case", "sigma"}};
  std::vector<std::string> parameters{"parameters"};
  bool unknown = false, elsewhere = false;
  for (const EffectShare& s : shares) {
    const std::string unit = effect_unit(spec, s);
    std::vector<std::string> row{s.effect.type, shortened(s.effect.joint, 24)};
    if (!s.share) {
      row.insert(row.end(), {"?", "?", "?"});
      unknown = true;
    } else if (!s.included) {
      row.insert(row.end(), {"-", "-", "-"});
      elsewhere = true;
    } else {
      row.insert(row.end(), {readable(s.share->mean, unit),
                             readable(std::abs(s.share->mean) + s.share->half_width, unit),
                             readable(s.share->sigma, unit)});
    }
    parameters.push_back(parameters_text(spec, s.effect));
    rows.push_back(std::move(row));
  }
  return with_texts(aligned_lines(rows), parameters, style.width) +
         (unknown ? "  ?: not known, and not in the figures below\n" : "") +
         (elsewhere ? "  -: affects the log or the reference only, not the robot\n" : "") +
         wrapped(
             !spec.motion ? "positions over the sampled ranges, speeds and loads up to the URDF's limits"
             : has_masses(spec.model.chain)
                 ? "what each adds alone along `motion:`"
                 : "what each adds alone along `motion:`, loads up to the URDF's limits: it has no masses",
             style.width, "  ");
}

std::string of_filter(const NamedFilter& f) { return escaped(f.name, 40) + ": " + norm_text(f); }

/// A statistic in the unit of the row.
std::vector<std::string> cells(const Statistic& s, const PrefixedUnit& unit) {
  const auto cell = [&](double value) {
    return std::isinf(value) ? "inf" : readable_number(cleaned(value) / unit.factor);
  };
  return {cell(s.p50), cell(s.max)};
}

/// A coordinate: its unit, and median and maximum of sigma, of sigma in motion, of the worst case.
std::vector<std::string> summary_row(const Signal& c, const std::string& si, const Statistic* sigma,
                                     const Statistic* in_motion, bool motion_column, const Statistic& worst) {
  const PrefixedUnit unit = prefixed(cleaned(worst.max), si);
  std::vector<std::string> row{c.name, unit.unit};
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
  const std::vector<Signal> coordinates = all_signals(a.spec.model);
  std::vector<std::string> differing;
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    const CoordinateStatistics& c = a.workspace.coordinates[i];
    const std::string unit(coordinates[i].unit);
    const std::string text = readable(cleaned(c.worst_case_rigorous.max), unit);
    if (std::isfinite(c.worst_case_rigorous.max) && text != readable(cleaned(c.worst_case.max), unit))
      differing.push_back(coordinates[i].name + ' ' + text);
  }
  if (differing.empty()) return "";
  return wrapped("with the linearization remainder (rigorous) at most " + listed(differing), style.width,
                 "  ");
}

/// The rows of the position, then those of each filter.
std::vector<TableRows> blocks_of(const Analysis& a, bool motion) {
  const std::vector<Signal> coordinates = all_signals(a.spec.model);
  const Workspace& w = a.workspace;
  std::vector<TableRows> blocks(1 + a.spec.filters.size());  // those of filters without signals stay empty
  for (std::size_t i = 0; i < coordinates.size(); ++i)
    blocks[0].push_back(summary_row(coordinates[i], coordinates[i].unit, &w.coordinates[i].sigma, nullptr,
                                    motion, w.coordinates[i].worst_case));
  for (std::size_t f = 0; f < a.spec.filters.size(); ++f)
    for (std::size_t i = 0; i < coordinates.size(); ++i) {
      if (!is_filtered(a.spec.filters[f], coordinates[i])) continue;
      const DerivativeStatistics& d = w.derivatives[f][i];
      blocks[f + 1].push_back(
          summary_row(coordinates[i], shown_unit(coordinates[i].unit, a.spec.filters[f].filter),
                      d.sigma ? &*d.sigma : nullptr, d.sigma_in_motion ? &*d.sigma_in_motion : nullptr,
                      motion, d.worst_case));
    }
  return blocks;
}

std::string title_of(const Analysis& a, std::size_t block, const Style& style) {
  return wrapped(block == 0 ? "position" : of_filter(a.spec.filters[block - 1]), style.width, "    ", "  ");
}

/// Median and maximum of every signal: one row a coordinate, one block a signal.
std::string table_of_rows(const Analysis& a, const Style& style) {
  bool motion = false;
  for (std::size_t f = 0; f < a.spec.filters.size(); ++f) motion = motion || is_known(a.noise_in_motion, f);
  std::vector<std::string> header{"", "", "sigma median", "sigma max"};
  if (motion) header.insert(header.end(), {"in motion median", "in motion max"});
  header.insert(header.end(), {"worst median", "worst max"});
  const std::vector<TableRows> blocks = blocks_of(a, motion);
  TableRows all{header};
  for (const TableRows& block : blocks) append(all, block);
  const std::vector<std::string> lines = lines_of(fitted_table(all, style.width, "    "));
  constexpr std::size_t tallest_header = 3;
  std::size_t at = lines.size() - (all.size() - 1);  // the line at which the next block begins
  const bool whole = at <= tallest_header;  // else, on a narrow terminal, columns are in several tables
  std::string out;
  for (std::size_t i = 0; whole && i < at; ++i) out += lines[i] + '\n';
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (blocks[i].empty()) continue;
    out += title_of(a, i, style);
    if (!whole) {
      TableRows rows{header};
      append(rows, blocks[i]);
      out += fitted_table(rows, style.width, "    ");
    }
    for (std::size_t row = 0; whole && row < blocks[i].size(); ++row) out += lines[at++] + '\n';
  }
  return out;
}

std::string summary_table(const Analysis& a, const Style& style) {
  std::string notes = "sigma: independent pseudo-quantization noise (IPQN)";
  if (has_effects(a)) notes += " and effects";
  if (a.spec.motion && !a.spec.filters.empty()) notes += "; in motion: encoders move as in `motion:`";
  return heading("Tip, estimate minus true, over the configurations", style) + table_of_rows(a, style) +
         rigorous_note(a, style) + wrapped(notes + "; all statistics: --details", style.width, "  ");
}

}  // namespace

std::string shown_unit(std::string_view unit, const Filter& filter) {
  return has_unknown_unit(filter) ? "" : derivative_unit(unit, filter);
}

double cleaned(double value) { return std::abs(value) < 1e-18 ? 0 : value; }

std::string rate_unit(int derivative) {
  return derivative == 0 ? "" : derivative == 1 ? "1/s" : "1/s^" + std::to_string(derivative);
}

std::string parameters_text(const Spec& spec, const Effect& effect) {
  std::vector<std::string> all;
  for (const EffectParameter& p : effect_parameters(spec, effect))
    if (!p.usual)
      all.push_back(p.name + ' ' + (p.unit.empty() ? significant(p.value, 4) : readable(p.value, p.unit)));
  for (const Parameter& row : effect_kind(effect.type).parameters) {
    const auto choice = effect.choices.find(std::string(row.name));
    if (choice != effect.choices.end()) all.push_back(choice->first + ' ' + choice->second);
  }
  return joined(all);
}

std::vector<TipEllipsoids> tip_ellipsoids(const Analysis& a) {
  std::vector<TipEllipsoids> all;
  if (a.workspace.covariance_at_largest.size() == 0) return all;
  const auto add = [&](std::string_view of, std::string_view unit, const Three& coordinates) {
    if (const auto at = find_three(a.spec.model, coordinates))
      all.push_back({of, unit, error_ellipsoid(block(a.workspace.mean_covariance, *at)),
                     error_ellipsoid(block(a.workspace.covariance_at_largest, *at))});
  };
  add("position", "m", {Coordinate::x, Coordinate::y, Coordinate::z});
  add("rotation", "rad", {Coordinate::rx, Coordinate::ry, Coordinate::rz});
  return all;
}

std::string to_table(const Analysis& a, const Style& style) {
  const Chain& chain = a.spec.model.chain;
  const std::string robot = "robot '" + escaped(a.spec.robot_name, 60) + "', " + escaped(chain.base, 60) +
                            " -> " + escaped(tips_of(a.spec.model), 120);
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
  out += accuracy_table(a, style) + count_rate_table(a.spec, style);
  if (!a.effects.empty())
    out +=
        heading("Effects: errors that they add at the joint", style) + effect_table(a.spec, a.effects, style);
  return out + (style.details ? detail_tables(a, style) : summary_table(a, style)) +
         (a.control ? control_text(a.spec, *a.control, style) : "") + exceedance_tables(a, style) +
         proof_table(a, style);
}

}  // namespace qerr
