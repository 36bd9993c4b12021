#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "kinematics/inverse_dynamics.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "report/analysis/control.hpp"
#include "report/analysis/count_rates.hpp"
#include "report/analysis/effects.hpp"
#include "report/analysis/tables.hpp"
#include "report/formats.hpp"
#include "report/text_table.hpp"

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

}  // namespace

std::string shown_unit(std::string_view unit, const Filter& filter) {
  return has_unknown_unit(filter) ? "" : derivative_unit(unit, filter);
}

double cleaned(double value) { return std::abs(value) < 1e-18 ? 0 : value; }

bool has_effects(const Analysis& a) { return !a.spec.model.sources.empty() || a.spec.model.along_motion; }

std::string rate_unit(int derivative) {
  return derivative == 0 ? "" : derivative == 1 ? "1/s" : "1/s^" + std::to_string(derivative);
}

std::string norm_text(const NamedFilter& f) {
  const std::string unit = f.filter.derivative == 0 ? "" : rate_unit(f.filter.derivative).substr(1);
  return "H2 norm " + significant(f.norms.h2, 5) + unit + ", l1 norm " + significant(f.norms.l1.upper, 5) +
         unit + ", " + readable(1 / f.filter.sample_rate, "s") + " a sample";
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

namespace {

/// Whether the encoder's share is the largest, or equal to it in what is printed.
std::vector<bool> largest_of(const std::vector<double>& shares) {
  const double largest = *std::max_element(shares.begin(), shares.end());
  std::vector<bool> all;
  for (const double share : shares) all.push_back(share > 0 && percent(share) == percent(largest));
  return all;
}

}  // namespace

std::string encoder_table(const Analysis& a, const Style& style) {
  std::vector<double> budget = encoder_budget(a);
  budget.resize(a.spec.model.chain.independent.size());
  const std::vector<bool> largest = largest_of(budget);
  const auto first = std::count(largest.begin(), largest.end(), true);
  const bool of_tip = !a.spec.model.coordinates.empty();
  TableRows rows{{"encoder", "resolution", "worst case", "sigma"}};
  if (of_tip) rows.front().emplace_back("share");
  for (std::size_t i = 0; i < budget.size(); ++i) {
    const IndependentJoint& joint = a.spec.model.chain.independent[i];
    const std::string unit = joint.prismatic() ? "m" : "rad";
    const auto row = static_cast<Eigen::Index>(i);
    rows.push_back({shortened(joint.name, 22), readable(a.resolutions[row], unit),
                    readable(a.joints.worst_case[row], unit), readable(a.joints.sigma[row], unit)});
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

namespace {

/// By how much sigma falls if a share of the variance vanishes.
double fall_of_sigma(double share) { return 1 - std::sqrt(std::max(0.0, 1 - share)); }

std::vector<std::string> row_of(const std::string& name, const std::string& count,
                                const std::string& accuracy, const BudgetParts& p, bool effects) {
  std::vector<std::string> row{name, count, accuracy, percent(p.quantization), percent(p.accuracy)};
  if (effects) row.push_back(percent(p.effects));
  return row;
}

}  // namespace

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
    const std::string unit = joint.prismatic() ? "m" : "rad";
    rows.push_back(row_of(shortened(joint.name, 22), readable(0.5 * encoder.resolution, unit),
                          slow > 0 ? readable(slow, unit) : "", parts[e], effects));
  }
  rows.push_back(row_of("all", "", "", sum, effects));
  return table_section("Accuracy or resolution: where the tip's variance comes from", rows, style,
                       "without the accuracies sigma would be " + percent(fall_of_sigma(sum.accuracy)) +
                           " less, with infinitely fine counts " + percent(fall_of_sigma(sum.quantization)) +
                           " less");
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

namespace {

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

}  // namespace

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

namespace {

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

}  // namespace

std::string summary_table(const Analysis& a, const Style& style) {
  std::string notes = "sigma: independent pseudo-quantization noise (IPQN)";
  if (has_effects(a)) notes += " and effects";
  if (a.spec.motion && !a.spec.filters.empty()) notes += "; in motion: encoders move as in `motion:`";
  return heading("Tip, estimate minus true, over the configurations", style) + table_of_rows(a, style) +
         rigorous_note(a, style) + wrapped(notes + "; all statistics: --details", style.width, "  ");
}

}  // namespace qerr
