#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "qerr/kinematics/coordinates.hpp"
#include "report/analysis/tables.hpp"
#include "report/text_table.hpp"

namespace qerr {

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

using Rows = std::vector<std::vector<std::string>>;

/// The rows of the position, then those of each filter.
std::vector<Rows> blocks_of(const Analysis& a, bool motion) {
  const std::vector<Signal> coordinates = all_signals(a.spec.model);
  const Workspace& w = a.workspace;
  std::vector<Rows> blocks(1 + a.spec.filters.size());  // those of filters without signals stay empty
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
  const std::vector<Rows> blocks = blocks_of(a, motion);
  Rows all{header};
  for (const Rows& block : blocks) all.insert(all.end(), block.begin(), block.end());
  const std::string text = fitted_table(all, style.width, "    ");
  constexpr std::size_t tallest_header = 3;
  const auto lines = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  const std::size_t above = lines - (all.size() - 1);
  std::string out;
  if (above > tallest_header) {  // a narrow terminal: the columns are in several tables
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      if (blocks[i].empty()) continue;
      Rows rows{header};
      rows.insert(rows.end(), blocks[i].begin(), blocks[i].end());
      out += title_of(a, i, style) + fitted_table(rows, style.width, "    ");
    }
    return out;
  }
  std::size_t at = 0, block = 0, next = above;  // the line at which the next block begins
  for (std::size_t line = 0; at < text.size(); ++line) {
    for (; line == next && block < blocks.size(); ++block) {
      next += blocks[block].size();
      if (!blocks[block].empty()) out += title_of(a, block, style);
    }
    const std::size_t end = text.find('\n', at);
    out += text.substr(at, end - at + 1);
    at = end + 1;
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
