
#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/text.hpp"
#include "qerr/core/quantity.hpp"
#include "report/analysis/figures.hpp"
#include "report/analysis/tables.hpp"
#include "report/page/page.hpp"
#include "report/sweep/sweep.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

/// Whether ascending values have equal ratios, within the digits with which a spec states them, and do not
/// have equal differences.
bool equal_ratios(const std::vector<double>& v) {
  constexpr double tolerance = 0.02;
  if (v.size() < 3 || !(v.front() > 0)) return false;
  const double steps = static_cast<double>(v.size() - 1);
  const double ratio = std::log(v.back() / v.front()) / steps, step = (v.back() - v.front()) / steps;
  bool in_log = true, linear = true;
  for (std::size_t i = 1; i < v.size(); ++i) {
    in_log = in_log && std::abs(std::log(v[i] / v[i - 1]) - ratio) <= tolerance * ratio;
    linear = linear && std::abs(v[i] - v[i - 1] - step) <= tolerance * step;
  }
  return in_log && !linear;
}

/// The values of a key, or none if they are not numbers, two different ones at least.
std::optional<SweepAbscissa> numeric_key(const SweepColumn& column) {
  SweepAbscissa a{column.axis, column.key, column.unit, column.values, {}, false};
  a.order.resize(a.values.size());
  std::iota(a.order.begin(), a.order.end(), std::size_t{0});
  std::ranges::stable_sort(a.order, [&](std::size_t x, std::size_t y) { return a.values[x] < a.values[y]; });
  if (a.values.empty() || a.values[a.order.front()] == a.values[a.order.back()]) return std::nullopt;
  std::vector<double> ascending;
  for (const std::size_t step : a.order)
    if (ascending.empty() || a.values[step] > ascending.back()) ascending.push_back(a.values[step]);
  a.logarithmic = equal_ratios(ascending);
  return a;
}

/// One of each axis that has such a key, with two values at least: of its first one.
std::vector<SweepAbscissa> abscissas_of(const SweepGrid& grid) {
  std::vector<SweepAbscissa> all;
  for (const SweepColumn& column : grid.columns())
    if (all.empty() || all.back().axis != column.axis)
      if (auto a = numeric_key(column)) all.push_back(std::move(*a));
  return all;
}

/// A value of a key for people: a number of many digits, such as the steps of a logarithmic range have, with
/// six of them.
std::string short_value(const std::string& name) {
  constexpr std::size_t long_number = 9;
  const std::string number = name.substr(0, name.find_first_not_of("0123456789.+-eE"));
  const auto value = parse_number(number);
  return value && number.size() >= long_number ? significant(*value, 6) + name.substr(number.size()) : name;
}

/// `most` of `count` numbers from 0 on, evenly spread, the first and the last one among them.
std::vector<std::size_t> evenly_chosen(std::size_t count, std::size_t most) {
  std::vector<std::size_t> chosen;
  const std::size_t wanted = std::min(count, most);
  for (std::size_t i = 0; i < wanted; ++i) chosen.push_back(wanted == 1 ? 0 : i * (count - 1) / (wanted - 1));
  return chosen;
}

constexpr std::size_t most_lines = 4;  ///< with a limit as many as the page has styles of lines
constexpr std::size_t most_bars = 20, point_bytes = 36, bar_bytes = 700;

std::uint64_t number_of(const SweepGrid& grid, const std::vector<std::size_t>& steps) {
  std::uint64_t number = 0;
  for (std::size_t a = 0; a < steps.size(); ++a) number = number * grid.axes()[a].steps.size() + steps[a];
  return number;
}

/// The steps of the other axes in their combination `index`, the first axis slowest.
std::vector<std::size_t> other_steps(const SweepGrid& grid, std::size_t without, std::uint64_t index) {
  std::vector<std::size_t> steps(grid.axes().size());
  for (std::size_t a = steps.size(); a-- > 0;) {
    if (a == without) continue;
    const std::size_t size = grid.axes()[a].steps.size();
    steps[a] = static_cast<std::size_t>(index % size);
    index /= size;
  }
  return steps;
}

std::string name_of_line(const SweepGrid& grid, std::size_t without, const std::vector<std::size_t>& steps) {
  std::vector<std::string> all;
  for (std::size_t a = 0; a < steps.size(); ++a) {
    const SweepAxis& axis = grid.axes()[a];
    for (std::size_t k = 0; k < axis.keys.size() && a != without; ++k)
      all.push_back(axis.keys[k] + " = " + short_value(axis.steps[steps[a]].names[k]));
  }
  return all.empty() ? "all variants" : joined(all);
}

DrawnVariants drawn_bars(const SweepGrid& grid, std::size_t figures, std::size_t most_bytes) {
  DrawnVariants d;
  d.points_in_all = static_cast<std::size_t>(grid.count());
  const std::size_t bars =
      std::clamp<std::size_t>(most_bytes / (bar_bytes * std::max<std::size_t>(figures, 1)), 2, most_bars);
  DrawnVariants::Line& line = d.lines.emplace_back();
  for (const std::size_t v : evenly_chosen(d.points_in_all, bars)) line.variants.push_back(v);
  return d;
}

DrawnVariants drawn_lines(const SweepGrid& grid, const SweepAbscissa& a, std::size_t figures,
                          std::size_t most_bytes) {
  DrawnVariants d;
  d.abscissa = a;
  d.points_in_all = a.values.size();
  d.lines_in_all = grid.count() / d.points_in_all;
  const std::vector<std::size_t> lines = evenly_chosen(d.lines_in_all, most_lines);
  const std::size_t points = std::clamp<std::size_t>(
      most_bytes / (point_bytes * lines.size() * std::max<std::size_t>(figures, 1)), 2, 400);
  for (const std::size_t index : lines) {
    std::vector<std::size_t> steps = other_steps(grid, a.axis, index);
    DrawnVariants::Line& line = d.lines.emplace_back();
    line.name = name_of_line(grid, a.axis, steps);
    for (const std::size_t i : evenly_chosen(d.points_in_all, points)) {
      steps[a.axis] = a.order[i];
      line.variants.push_back(number_of(grid, steps));
    }
  }
  return d;
}

/// Over each axis of numbers in turn, at most four of them; one, of bars, where there is none.
/// @param figures     that are drawn of each variant
/// @param most_bytes  of the pictures, about
std::vector<DrawnVariants> drawn_variants(const SweepGrid& grid, std::size_t figures,
                                          std::size_t most_bytes) {
  constexpr std::size_t most_keys = 4;
  std::vector<SweepAbscissa> keys = abscissas_of(grid);
  if (keys.empty()) return {drawn_bars(grid, figures, most_bytes)};
  if (keys.size() > most_keys) keys.resize(most_keys);
  std::vector<DrawnVariants> all;
  for (const SweepAbscissa& key : keys)
    all.push_back(drawn_lines(grid, key, figures, most_bytes / keys.size()));
  return all;
}

constexpr std::size_t most_figures = 24;

bool same_requirements(const Spec& a, const Spec& b) {
  return std::equal(a.requirements.begin(), a.requirements.end(), b.requirements.begin(),
                    b.requirements.end(), [](const Requirement& x, const Requirement& y) {
                      return x.name() == y.name() && x.limit == y.limit && x.at_least == y.at_least;
                    });
}

/// Up to this many points of a picture each has a mark with all its digits.
constexpr std::size_t most_marks = 250;
/// Beyond this ratio of the values the small ones would lie on a linear axis.
constexpr double wide_range = 20;

std::string first_upper(std::string text) {
  if (!text.empty()) text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text;
}

}  // namespace

double DrawnVariants::value(const SweepGrid& grid, std::uint64_t variant) const {
  return abscissa->values[grid.steps(variant)[abscissa->axis]];
}

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
  const auto add = [&](SweptQuantity f) {
    if (!find_named(figures_, f.name) && figures_.size() < most_figures) figures_.push_back(std::move(f));
  };
  for (std::size_t i = 0; i < spec.requirements.size(); ++i)
    add({spec.requirements[i].name(), spec.requirements[i].unit, static_cast<std::ptrdiff_t>(i)});
  const std::vector<Signal> coordinates = all_signals(spec.model);
  for (const Signal& c : coordinates) add({"position." + c.name + ".worst_case max", c.unit});
  for (const NamedFilter& f : spec.filters)
    for (const Signal& c : coordinates)
      if (is_filtered(f, c)) add({f.name + '.' + c.name + ".sigma max", shown_unit(c.unit, f.filter)});
}

SweepPage::VariantFigures SweepPage::row(const SweptVariant& v) const {
  VariantFigures row{'-', false,
                     std::vector<double>(figures_.size(), std::numeric_limits<double>::quiet_NaN())};
  if (!v.check) return row;
  if (!v.check->results.empty()) row.verdict = v.check->all_met() ? 'y' : 'n';
  const Analysis& a = v.check->analysis;
  const Spec& base = variants_.base();
  // Requirements are compared by their place: they must stand for the same figures.
  const bool same = a.spec.requirements.size() == base.requirements.size();
  row.other_limits = !same_requirements(a.spec, base);
  std::map<std::string, double> known;
  for_each_figure(
      a, [&](const FigureName& name, const Statistic& s) { known.emplace(name.quantity() + " max", s.max); });
  for (std::size_t i = 0; i < figures_.size(); ++i) {
    const auto r = static_cast<std::size_t>(figures_[i].requirement);
    if (figures_[i].requirement < 0) {
      if (const auto found = known.find(figures_[i].name); found != known.end())
        row.values[i] = found->second;
    } else if (same && r < v.check->results.size() && a.spec.requirements[r].name() == figures_[i].name) {
      row.values[i] = v.check->results[r].value;
    }
  }
  return row;
}

/// The requirement of the spec whose value the figure is; null for any other.
const Requirement* SweepPage::required(const SweptQuantity& f) const {
  return f.requirement < 0 ? nullptr : &variants_.base().requirements[f.requirement];
}

/// @pre the variant is kept
double SweepPage::value(std::size_t figure, std::uint64_t variant) const {
  const std::vector<double>& values = kept_.at(variant).values;
  return figure < values.size() ? values[figure] : NAN;
}

/// The largest part of a limit that a variant uses; empty where a requirement has none.
std::optional<double> SweepPage::tightest(const VariantFigures& row) const {
  double largest = -1;
  for (std::size_t i = 0; i < std::min(figures_.size(), row.values.size()); ++i) {
    const Requirement* const r = required(figures_[i]);
    if (!r) continue;
    const auto part = part_of_limit(*r, {.value = row.values[i]});
    if (!part || !std::isfinite(*part)) return std::nullopt;
    largest = std::max(largest, *part);
  }
  return largest < 0 ? std::nullopt : std::optional(largest);
}

void SweepPage::add(const VariantFigures& row) {
  limits_vary_ = limits_vary_ || row.other_limits;
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

std::string SweepPage::answer() const {
  std::string text;
  if (judged_ > 0)
    text = std::to_string(met_) + " of " + counted(grid_.count(), "variant") +
           (met_ == 1 ? " meets" : " meet") + " all requirements";
  if (best_ && !limits_vary_ && grid_.count() > 1)
    text += "; variant " + std::to_string(best_->variant) + " wins, with " +
            page::isolated(grid_.description(best_->variant, short_value)) + ": it takes " +
            percent(best_->value) + " of its tightest limit";
  // The first figure that varies says most.
  std::size_t i = 0;
  while (i < least_.size() && (!least_[i] || least_[i]->value == largest_[i]->value)) ++i;
  if (i == least_.size())
    i = static_cast<std::size_t>(std::ranges::find_if(least_, [](const auto& e) { return e.has_value(); }) -
                                 least_.begin());
  if (i == least_.size()) return text.empty() ? "No variant has a figure." : text + '.';
  const Extreme &least = *least_[i], &largest = *largest_[i];
  if (!text.empty()) text += "; ";
  const std::string name = page::isolated(figures_[i].name);
  if (least.value == largest.value)
    return first_upper(text + name + " is " + readable(least.value, figures_[i].unit) + " in every variant.");
  return text + name + " is least, " + readable(least.value, figures_[i].unit) + ", with " +
         page::isolated(grid_.description(least.variant, short_value)) + ", and largest, " +
         readable(largest.value, figures_[i].unit) + ", with " +
         page::isolated(grid_.description(largest.variant, short_value)) + ".";
}

std::string SweepPage::plot(std::size_t figure, const DrawnVariants& drawn) const {
  const SweptQuantity& f = figures_[figure];
  const SweepAbscissa& a = *drawn.abscissa;
  page::Plot plot{&drawn == drawn_.data() ? f.name : f.name + " over " + a.key,
                  "The figure over the values of a key of the spec, one line for each combination of the "
                  "other keys.",
                  {page::shortened(a.key, 46), a.unit, a.logarithmic},
                  {page::shortened(f.name, 46), f.unit},
                  {}};
  std::size_t marks = 0;
  for (const DrawnVariants::Line& line : drawn.lines) marks += figures_.size() * line.variants.size();
  double least = INFINITY, largest = 0;
  for (const DrawnVariants::Line& line : drawn.lines) {
    page::Series series{line.name, {}, marks <= most_marks};
    for (const std::uint64_t v : line.variants) {
      const double y = value(figure, v);
      series.points.emplace_back(drawn.value(grid_, v), y);
      if (std::isfinite(y)) least = std::min(least, y), largest = std::max(largest, y);
    }
    // Combinations of keys that change nothing are one line.
    const auto same =
        std::ranges::find_if(plot.series, [&](const page::Series& s) { return s.points == series.points; });
    if (same == plot.series.end())
      plot.series.push_back(std::move(series));
    else
      same->name += "; " + series.name;
  }
  if (!(least <= largest)) return "<p>No variant that is drawn has this figure.</p>";
  plot.y.logarithmic = least > 0 && largest > wide_range * least;
  if (const Requirement* const r = limits_vary_ ? nullptr : required(f))
    plot.series.push_back(
        {std::string("required: at ") + (r->at_least ? "least " : "most ") + readable(r->limit, r->unit),
         {{a.values[a.order.front()], r->limit}, {a.values[a.order.back()], r->limit}}});
  return page::figure(plot);
}

/// The figure by the key of the abscissa and by the others: the darker, the larger; what misses its
/// requirement is crossed. "" of one line, and of more cells than a reader, or the page, takes.
std::string SweepPage::matrix(std::size_t figure, const DrawnVariants& drawn) const {
  constexpr std::size_t most_columns = 16, most_cells = 1500;  // 80 bytes each
  const std::size_t columns = drawn.lines.front().variants.size(), rows = drawn.lines.size();
  if (rows < 2 || columns > most_columns || rows * columns * figures_.size() > most_cells) return "";
  const SweptQuantity& f = figures_[figure];
  double least = INFINITY, largest = -INFINITY;
  for (const DrawnVariants::Line& line : drawn.lines)
    for (const std::uint64_t v : line.variants)
      if (const double y = value(figure, v); std::isfinite(y))
        least = std::min(least, y), largest = std::max(largest, y);
  if (!(least <= largest)) return "";
  const std::vector<std::string> keys = grid_.keys();
  const auto key = static_cast<std::size_t>(std::ranges::find(keys, drawn.abscissa->key) - keys.begin());
  std::vector<std::string> header{drawn.abscissa->key}, rows_of_cells;
  for (const std::uint64_t v : drawn.lines.front().variants)
    header.push_back(short_value(grid_.names(v)[key]));
  const Requirement* const limit = limits_vary_ ? nullptr : required(f);
  for (const DrawnVariants::Line& line : drawn.lines) {
    std::string row = "<th scope=\"row\">" + page::name_markup(line.name) + "</th>";
    for (const std::uint64_t v : line.variants) {
      const double y = value(figure, v), part = largest > least ? (y - least) / (largest - least) : 0;
      const bool missed = limit && (limit->at_least ? y < limit->limit : y > limit->limit);
      row += std::isfinite(y)
                 ? "<td style=\"--p:" + significant(std::round(45 * part), 2) + "%\">" +
                       (missed ? "\u2717 " : "") + page::escaped_markup(readable(y, f.unit)) + "</td>"
                 : "<td>-</td>";
    }
    rows_of_cells.push_back(row);
  }
  return page::table_of("matrix", header, rows_of_cells) +
         (limit ? "<p>\u2717: the requirement is not met.</p>" : "");
}

std::string SweepPage::bars(std::size_t figure, const DrawnVariants& drawn) const {
  const SweptQuantity& f = figures_[figure];
  page::Bars bars{f.name, "The figure of each variant.", {}, {"", f.unit}};
  for (const std::uint64_t v : drawn.lines.front().variants) {
    const double y = value(figure, v);
    if (std::isfinite(y) && y >= 0) bars.bars.push_back({grid_.description(v), y, readable(y, f.unit)});
  }
  return bars.bars.empty() ? "<p>No variant that is drawn has this figure.</p>" : page::figure(bars);
}

std::string SweepPage::picture(std::size_t figure, const DrawnVariants& drawn) const {
  if (!drawn.abscissa) return bars(figure, drawn);
  const std::string cells = matrix(figure, drawn);
  return cells.empty() ? plot(figure, drawn)
                       : "<div class=\"figures\">" + plot(figure, drawn) + "<div>" + cells + "</div></div>";
}

std::string SweepPage::what_is_drawn(const DrawnVariants& drawn) const {
  const std::size_t points = drawn.lines.front().variants.size();
  std::string text;
  if (drawn.abscissa)
    text = "Over " + drawn.abscissa->key + (drawn.abscissa->logarithmic ? ", logarithmic. " : ". ");
  if (drawn.lines.size() < drawn.lines_in_all)
    text += std::to_string(drawn.lines.size()) + " of " + std::to_string(drawn.lines_in_all) +
            " combinations of the other keys are drawn, evenly spread over the grid. ";
  if (points < drawn.points_in_all)
    text += std::to_string(points) + " of " + std::to_string(drawn.points_in_all) +
            (drawn.abscissa ? " values of the key" : " variants") + " are drawn, evenly spread. ";
  if (limits_vary_) text += "The sweep changes the requirements, so that no limit is drawn. ";
  return text.empty() ? "" : "<p>" + page::escaped_markup(text) + "</p>";
}

std::string SweepPage::table() const {
  constexpr std::size_t columns = 4, most_bytes = 60'000;
  const std::size_t shown_figures = std::min(columns, figures_.size());
  std::vector<std::string> header{"variant"};
  for (const std::string& key : grid_.keys()) header.push_back(in_words(key));
  for (std::size_t i = 0; i < shown_figures; ++i) header.push_back(in_words(figures_[i].name));
  if (judged_ > 0) header.emplace_back("met");
  TableRows rows;
  std::size_t bytes = 0;
  for (const auto& [variant, row] : kept_) {
    if (variant != rows.size()) break;  // rows beyond the first ones are kept for the pictures only
    std::vector<std::string> cells{std::to_string(variant)};
    for (const std::string& value : grid_.names(variant)) cells.push_back(short_value(value));
    for (std::size_t i = 0; i < shown_figures; ++i) {
      const double y = value(i, variant);
      cells.push_back(std::isnan(y) ? "-" : readable(y, figures_[i].unit));
    }
    if (judged_ > 0) cells.emplace_back(row.verdict == 'y' ? "yes" : row.verdict == 'n' ? "NO" : "-");
    if (judged_ > 0 && best_ && !limits_vary_ && variant == best_->variant) cells.back() += ", wins";
    for (const std::string& cell : cells) bytes += cell.size() + 20;
    if (bytes > most_bytes) break;
    rows.push_back(std::move(cells));
  }
  std::string out = page::table(header, rows);
  if (rows.size() < grid_.count())
    out += "<p>The first " + std::to_string(rows.size()) + " of " + counted(grid_.count(), "variant") +
           ": the CSV of the sweep has all.</p>";
  if (shown_figures < figures_.size())
    out += "<p>The other figures are drawn above, and in the CSV of the sweep.</p>";
  return out;
}

std::string SweepPage::text(const SweepOutcome& outcome) const {
  constexpr std::size_t most_spec = 40'000;
  std::vector<std::pair<std::string, std::string>> keys;
  for (const DrawnVariants& drawn : drawn_) {
    std::vector<std::pair<std::string, std::string>> pictures;
    for (std::size_t i = 0; i < figures_.size(); ++i)
      pictures.emplace_back(figures_[i].name, picture(i, drawn));
    keys.emplace_back(drawn.abscissa ? drawn.abscissa->key : "",
                      what_is_drawn(drawn) + page::choice("Figure", pictures));
  }
  const Spec& spec = variants_.base();
  page::Page page{"Sweep of " + spec.robot_name,
                  answer(),
                  {{"Figures over the keys", page::choice("Over", keys)}, {"Variants", table()}}};
  for (const std::string& warning : spec.warnings)
    if (!warning.starts_with("sweep: ")) page.warnings.push_back(warning);
  page.warnings.insert(page.warnings.end(), outcome.faults.begin(), outcome.faults.end());
  if (outcome.counts.failed > 0)
    page.warnings.push_back(counted(outcome.counts.failed, "variant") +
                            " cannot be computed or judged; the lines have gaps there");
  describe(page, spec, std::nullopt);
  page.spec_text = spec.text.size() <= most_spec
                       ? spec.text
                       : spec.text.substr(0, spec.text.rfind('\n', most_spec)) + "\n... (cut)\n";
  return markup(page);
}

}  // namespace qerr
