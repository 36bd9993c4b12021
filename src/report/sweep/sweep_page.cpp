#include "report/sweep/sweep_page.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "qerr/core/quantity.hpp"
#include "report/analysis/figure_names.hpp"
#include "report/analysis/requirements.hpp"
#include "report/analysis/tables.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

constexpr char end_of_value = '\t', end_of_row = '\n', other_limits = '!';
constexpr std::size_t most_figures = 24;

/// Whether the requirements of a variant are those of the spec.
bool same_requirements(const Spec& a, const Spec& b) {
  return std::equal(a.requirements.begin(), a.requirements.end(), b.requirements.begin(),
                    b.requirements.end(), [](const Requirement& x, const Requirement& y) {
                      return x.name() == y.name() && x.limit == y.limit && x.at_least == y.at_least;
                    });
}

std::string written_value(double value) { return std::isnan(value) ? "-" : shortest(value); }

double read_value(const std::string& text) {
  if (text == "-") return std::numeric_limits<double>::quiet_NaN();
  return parse_number(text).value_or(std::numeric_limits<double>::infinity());
}

}  // namespace

SweepPage::SweepPage(const SpecVariants& variants, const SweepGrid& grid) : variants_(variants), grid_(grid) {
  constexpr std::size_t bytes_of_pictures = 130'000;
  constexpr std::uint64_t rows_of_table = 120;
  add_figures();
  drawn_ = drawn_variants(grid, figures_.size(), bytes_of_pictures);
  for (const DrawnVariants& drawn : drawn_)
    for (const DrawnVariants::Line& line : drawn.lines)
      for (const std::uint64_t v : line.variants) kept_[v];
  for (std::uint64_t v = 0; v < std::min(grid.count(), rows_of_table); ++v) kept_[v];
  least_.resize(figures_.size());
  largest_.resize(figures_.size());
}

void SweepPage::add_figures() {
  const Spec& spec = variants_.base();
  const auto add = [&](Figure f) {
    const bool known =
        std::any_of(figures_.begin(), figures_.end(), [&](const Figure& k) { return k.name == f.name; });
    if (!known && figures_.size() < most_figures) figures_.push_back(std::move(f));
  };
  for (std::size_t i = 0; i < spec.requirements.size(); ++i)
    add({spec.requirements[i].name(), spec.requirements[i].unit, static_cast<std::ptrdiff_t>(i)});
  const std::vector<Signal> coordinates = all_signals(spec.model);
  for (const Signal& c : coordinates) add({"position." + c.name + ".worst_case max", c.unit});
  for (const NamedFilter& f : spec.filters)
    for (const Signal& c : coordinates)
      if (is_filtered(f, c)) add({f.name + '.' + c.name + ".sigma max", shown_unit(c.unit, f.filter)});
}

std::string SweepPage::row(const SweptVariant& v) const {
  std::vector<double> values(figures_.size(), std::numeric_limits<double>::quiet_NaN());
  std::string text(1, v.check && !v.check->results.empty() ? (v.check->all_met() ? 'y' : 'n') : '-');
  if (v.check) {
    const Analysis& a = v.check->analysis;
    const Spec& base = variants_.base();
    // Requirements are compared by their place: they must stand for the same figures.
    const bool same = a.spec.requirements.size() == base.requirements.size();
    if (!same_requirements(a.spec, base)) text += other_limits;
    for (std::size_t i = 0; i < figures_.size() && same; ++i) {
      const auto r = static_cast<std::size_t>(figures_[i].requirement);
      if (figures_[i].requirement >= 0 && r < v.check->results.size() &&
          a.spec.requirements[r].name() == figures_[i].name)
        values[i] = v.check->results[r].value;
    }
    std::map<std::string, double> known;
    for_each_figure(a, [&](const FigureName& name, const Statistic& s) {
      known.emplace(name.quantity() + " max", s.max);
    });
    for (std::size_t i = 0; i < figures_.size(); ++i)
      if (const auto found = known.find(figures_[i].name);
          figures_[i].requirement < 0 && found != known.end())
        values[i] = found->second;
  }
  for (const double value : values) text += end_of_value + written_value(value);
  return text + end_of_row;
}

/// The largest part of a limit that a variant uses; empty where a requirement has none.
std::optional<double> SweepPage::tightest(const Row& row) const {
  double largest = -1;
  for (std::size_t i = 0; i < std::min(figures_.size(), row.values.size()); ++i) {
    if (figures_[i].requirement < 0) continue;
    const Requirement& r = variants_.base().requirements[static_cast<std::size_t>(figures_[i].requirement)];
    const auto part = part_of_limit(r, {.value = row.values[i]});
    if (!part || !std::isfinite(*part)) return std::nullopt;
    largest = std::max(largest, *part);
  }
  return largest < 0 ? std::nullopt : std::optional(largest);
}

void SweepPage::take(const Row& row) {
  if (const auto part = tightest(row); part && (!best_ || *part < best_->value)) best_ = {*part, next_};
  judged_ += row.verdict != '-';
  met_ += row.verdict == 'y';
  for (std::size_t i = 0; i < row.values.size(); ++i) {
    const double value = row.values[i];
    if (!std::isfinite(value)) continue;
    if (!least_[i] || value < least_[i]->value) least_[i] = {value, next_};
    if (!largest_[i] || value > largest_[i]->value) largest_[i] = {value, next_};
  }
  if (const auto kept = kept_.find(next_); kept != kept_.end()) kept->second = row;
  ++next_;
}

void SweepPage::add(const std::string& rows) {
  for (std::size_t begin = 0; begin < rows.size();) {
    const std::size_t end = rows.find(end_of_row, begin);
    Row row;
    row.verdict = rows[begin];
    limits_vary_ = limits_vary_ || rows[begin + 1] == other_limits;
    std::size_t from = rows.find(end_of_value, begin);
    while (from < end) {
      const std::size_t stop = std::min(rows.find(end_of_value, from + 1), end);
      row.values.push_back(read_value(rows.substr(from + 1, stop - from - 1)));
      from = stop;
    }
    take(row);
    begin = end + 1;
  }
}

}  // namespace qerr
