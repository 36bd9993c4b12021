#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <numbers>
#include <optional>
#include <string>

#include "core/text.hpp"
#include "design/filter_choice.hpp"
#include "qerr/core/error.hpp"
#include "qerr/report/filter_report.hpp"
#include "report/analysis/figures.hpp"
#include "report/analysis/tables.hpp"
#include "report/formats.hpp"
#include "report/page/page.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

/// The cut-off that the filter was designed with [Hz].
std::optional<double> stated_cutoff(const FilterFigures& f) {
  if (!f.designed) return std::nullopt;
  const auto& numbers = f.designed->parameters.numbers;
  const auto cutoff = numbers.find("cutoff");
  return cutoff == numbers.end() ? std::nullopt : std::optional(cutoff->second);
}

/// The norms of the same design at another cut-off; empty where the family has none or they exceed the range
/// of double.
std::optional<Norms> norms_at(const FamilyDesign& design, double cutoff) {
  FilterDesign parameters = design.parameters;
  parameters.numbers["cutoff"] = cutoff;
  try {
    const Norms n = norms(design.family->design(parameters));
    return std::isfinite(n.h2) && std::isfinite(n.l1.upper) ? std::optional(n) : std::nullopt;
  } catch (const Error& e) {
    if (e.trouble() != Trouble::input) throw;
    return std::nullopt;
  }
}

/// A low-pass of the scan, or a filter of the report.
struct ScannedFilter {
  std::string name;
  std::optional<double> cutoff;
  double delay = 0, h2 = 0;
};

/// Cut-offs in equal ratios, the same ones in every scan, with three digits such as 158 Hz. A design takes a
/// third of a millisecond: five a decade keep the page below 0.3 s.
std::vector<double> cutoffs_between(double least, double most) {
  constexpr int a_decade = 5;
  std::vector<double> all;
  const auto first = static_cast<int>(std::ceil(a_decade * std::log10(least) - 1e-9));
  const auto last = static_cast<int>(std::floor(a_decade * std::log10(most) + 1e-9));
  for (int i = first; i <= last; ++i)
    all.push_back(rounded_to(std::pow(10, static_cast<double>(i) / a_decade), 3));
  return all;
}

void scan_family(const FilterFamily& family, int derivative, double sample_rate,
                 const std::vector<double>& cutoffs, std::vector<ScannedFilter>& to) {
  for (const int order : {1, 2, 4}) {
    if (order > 1 && !find_named(family.parameters, "order")) break;
    for (const double cutoff : cutoffs) {
      const std::optional<Filter> filter =
          low_pass(std::string(family.name), order, cutoff, derivative, sample_rate);
      if (!filter || !passes_slow_motion(*filter)) continue;
      const double h2 = h2_norm(*filter);
      if (std::isfinite(h2))
        to.push_back({std::string(family.name) + ", order " + std::to_string(order), cutoff,
                      group_delay(*filter), h2});
    }
  }
}

/// The filters that no other one equals in delay and noise, by ascending delay.
std::vector<ScannedFilter> undominated(std::vector<ScannedFilter> all) {
  std::ranges::stable_sort(all, [](const ScannedFilter& a, const ScannedFilter& b) {
    return a.delay != b.delay ? a.delay < b.delay : a.h2 < b.h2;
  });
  std::vector<ScannedFilter> front;
  for (ScannedFilter& f : all)
    if (front.empty() || f.h2 < front.back().h2) front.push_back(std::move(f));
  return front;
}

std::vector<ScannedFilter> front_of(const std::vector<const FilterFigures*>& filters) {
  constexpr double around = 10;
  double least = INFINITY, most = 0;
  for (const FilterFigures* f : filters) {
    const double rate = f->filter.sample_rate;
    const double middle = stated_cutoff(*f).value_or(f->bandwidth.value_or(0.05 * rate));
    least = std::min(least, middle / around), most = std::max(most, middle * around);
  }
  const Filter& like = filters.front()->filter;
  // Bandwidths may lie decades apart: three decades below the highest cut-off keep the scan short.
  most = std::min(most, 0.45 * like.sample_rate);
  least = std::max(least, 1e-3 * most);
  std::vector<ScannedFilter> all;
  for (const FilterFamily& family : filter_families())
    if (find_named(family.parameters, "cutoff"))
      scan_family(family, like.derivative, like.sample_rate, cutoffs_between(least, most), all);
  for (const FilterFigures* f : filters)
    if (passes_slow_motion(f->filter))
      all.push_back({f->name, stated_cutoff(*f), f->group_delay, f->norms.h2});
  return undominated(std::move(all));
}

/// The quietest low-pass within each of some round delays, around those of the spec's filters.
std::string delay_table(const std::vector<ScannedFilter>& front, double most, const std::string& unit) {
  TableRows rows;
  for (int decade = -7; decade < 3; ++decade)
    for (const double digit : {1.0, 2.0, 3.0, 5.0}) {
      const double delay = digit * std::pow(10, decade);
      const auto after =
          std::ranges::find_if(front, [&](const ScannedFilter& f) { return f.delay > delay * (1 + 1e-9); });
      if (after == front.begin() || delay > most) continue;
      const ScannedFilter& f = *(after - 1);
      if (f.delay <= 0 || f.delay < 0.1 * delay) continue;
      rows.push_back({readable(delay, "s"), f.name + (f.cutoff ? " at " + readable(*f.cutoff, "Hz") : ""),
                      readable(f.delay, "s"), readable(f.h2, unit)});
    }
  return rows.empty() ? "" : page::table({"delay up to", "quietest low-pass", "has", "H2 norm"}, rows);
}

/// @param title  of the picture
std::string noise_figure(const std::string& title, const std::vector<const FilterFigures*>& filters) {
  const Filter& like = filters.front()->filter;
  const std::string unit = rate_unit(like.derivative);
  page::Plot plot{title,
                  "H2 norm, the factor of white noise, over the group delay at low frequencies: the filters "
                  "of the spec, and those low-passes that no other one equals in both.",
                  {"delay", "s"},
                  {"H2 norm", unit, true},
                  {}};
  for (const FilterFigures* f : filters)
    plot.series.push_back({f->name, {{f->group_delay, f->norms.h2}}, true, false});
  const std::vector<ScannedFilter> front = front_of(filters);
  // Delays of the front span decades; those of predictors, at or below 0, have no logarithm: they are told
  // below the picture, unless there is no other.
  const auto is_late = [](const FilterFigures* filter) { return filter->group_delay > 0; };
  plot.x.logarithmic = std::ranges::any_of(filters, is_late);
  std::string early;
  for (const FilterFigures* f : filters)
    if (plot.x.logarithmic && !is_late(f))
      early += "<p>Left of the picture: " + page::name_markup(f->name) + ", delay " +
               readable(f->group_delay, "s") + ", H2 norm " + readable(f->norms.h2, unit) + ".</p>";
  // Of finitely many filters the front is a staircase: what lies above it is equalled by a step's filter.
  page::Series line{"undominated low-passes", {}};
  for (std::size_t i = 0; i < front.size(); ++i) {
    if (i > 0) line.points.emplace_back(front[i].delay, front[i - 1].h2);
    line.points.emplace_back(front[i].delay, front[i].h2);
  }
  plot.series.push_back(line);
  double slowest = 0;
  for (const FilterFigures* f : filters) slowest = std::max(slowest, 3 * f->group_delay);
  return "<div>" + figure(plot) + early + delay_table(front, slowest, unit) + "</div>";
}

/// ||H||_2 and ||H||_1 of the same family at cut-offs from a tenth to ten times the stated one, and the
/// stated one marked; a sentence for a filter that has no cut-off.
std::string cutoff_figure(const FilterFigures& f) {
  const std::optional<double> stated = stated_cutoff(f);
  if (!stated)
    return "<p>" + page::name_markup(f.name) +
           (f.designed ? " is of a family without a cut-off" : " is given by its coefficients") +
           ": there are no norms over a cut-off.</p>";
  constexpr int points = 8;  // on each side, over a decade
  const std::string unit = rate_unit(f.filter.derivative);
  page::Plot plot{"Norms of " + f.name + " over the cut-off",
                  "Factor of white noise (H2 norm) and of the worst case (l1 norm) of the same low-pass at "
                  "other cut-offs, this one marked.",
                  {"cut-off", "Hz", true},
                  {"factor", unit, true},
                  {{"sigma, H2 norm", {}}, {"worst case, l1 norm", {}}}};
  for (int i = -points; i <= points; ++i) {
    const double cutoff = *stated * std::pow(10, static_cast<double>(i) / points);
    const std::optional<Norms> n = i == 0 ? std::optional(f.norms) : norms_at(*f.designed, cutoff);
    if (!n) continue;
    plot.series[0].points.emplace_back(cutoff, n->h2);
    plot.series[1].points.emplace_back(cutoff, n->l1.upper);
  }
  plot.series.push_back({"this filter", {{*stated, f.norms.h2}, {*stated, f.norms.l1.upper}}, true, false});
  return figure(plot);
}

/// Noise against delay, one picture for each derivative and sample rate: the report's filters, and the
/// undominated low-passes of all families that have a cut-off.
std::string noise_figures(const FilterReport& r) {
  std::map<std::pair<int, double>, std::vector<const FilterFigures*>> groups;
  for (const FilterFigures& f : r.filters) groups[{f.filter.derivative, f.filter.sample_rate}].push_back(&f);
  std::string out =
      "<p>Every low-pass family with a cut-off, at orders 1, 2 and 4, and the filters of the spec: none of "
      "them lies below the line. A filter above it has a quieter one of its delay, or a faster one of its "
      "noise; how far they track the motion is not compared.</p><div class=\"figures\">";
  for (const auto& [like, filters] : groups) {
    const auto [derivative, rate] = like;
    const bool several_rates = std::ranges::count_if(groups, [order = derivative](const auto& g) {
                                 return g.first.first == order;
                               }) > 1;
    out += noise_figure("Noise against delay, derivative " + std::to_string(derivative) +
                            (several_rates ? " at " + readable(rate, "Hz") : ""),
                        filters);
  }
  return out + "</div>";
}

using Points = std::vector<std::pair<double, double>>;

/// Points of a line: fewer where a page has the lines of many filters, so that it stays below 300 kB.
int points_of_line(std::size_t filters, int usual) {
  constexpr std::size_t usual_filters = 8;
  constexpr int least = 24;
  return std::max(
      least, usual * static_cast<int>(usual_filters) / static_cast<int>(std::max(filters, usual_filters)));
}

/// Gain beside that of the derivative itself, (2 pi f)^d, and phase behind that of (i 2 pi f)^d, without
/// jumps: a constant delay T is a phase of -360 f T degrees.
std::string response_figures(const FilterFigures& f, std::size_t filters) {
  const int points = points_of_line(filters, 160);
  const double last = 0.499 * f.filter.sample_rate;
  const double first = std::min(1e-3 * f.filter.sample_rate, 1e-2 * f.bandwidth.value_or(last));
  page::Series gain{"filter", {}},
      phase = gain, delay{"constant delay of " + readable(f.group_delay, "s"), {}},
      ideal{f.filter.derivative == 0 ? "ideal position" : "ideal derivative", {}};
  double turns = 0, before = 0, peak = 0, lowest = 0;
  for (int i = 0; i <= points; ++i) {
    const double frequency = first * std::pow(last / first, static_cast<double>(i) / points);
    const std::complex<double> value = response(f.filter, frequency),
                               wanted = std::pow(std::complex<double>(0, 2 * std::numbers::pi * frequency),
                                                 f.filter.derivative);
    gain.points.emplace_back(frequency, std::abs(value));
    ideal.points.emplace_back(frequency, std::abs(wanted));
    const double angle = std::arg(value / wanted) * 180 / std::numbers::pi;
    if (i > 0) turns -= std::round((angle - before) / 360);
    before = angle;
    phase.points.emplace_back(frequency, angle + 360 * turns);
    delay.points.emplace_back(frequency, -360 * frequency * f.group_delay);
    peak = std::max(peak, std::abs(value)), lowest = std::min(lowest, phase.points.back().second);
  }
  // Zeros of the response would stretch the logarithmic axis without bound: four decades below the peak is
  // far below what passes. Far beyond the band the line of the delay would stretch the other.
  std::erase_if(gain.points, [&](const auto& p) { return p.second < 1e-4 * peak; });
  std::erase_if(delay.points, [&](const auto& p) { return p.second < 1.2 * lowest - 1; });
  const page::AxisRange over{"frequency", "Hz", true};
  return figure(page::Plot{"Gain of " + f.name,
                           "Magnitude of the response over frequency, beside the ideal derivative.",
                           over,
                           {"gain", rate_unit(f.filter.derivative), true},
                           {gain, ideal}}) +
         figure(page::Plot{"Phase of " + f.name,
                           "Phase of the response over frequency behind the ideal derivative, beside that of "
                           "a constant delay.",
                           over,
                           {"phase", "deg", false, false},
                           {phase, delay}});
}

/// Samples until the answer has settled; of a long one every n-th.
struct Span {
  std::size_t count, every;
};

Span span_of(const FilterFigures& f, std::size_t filters) {
  constexpr double most_computed = 2e6;
  const double most_drawn = points_of_line(filters, 200);
  const double settling = f.settling_time.value_or(50 / f.filter.sample_rate);
  const double wanted = std::min(1.5 * settling * f.filter.sample_rate + 8, most_computed);
  const double every = std::ceil(wanted / most_drawn);
  return {static_cast<std::size_t>(wanted / every), static_cast<std::size_t>(every)};
}

/// Answers to a sample of 1 among zeros and to a step of 1.
std::string answer_figures(const FilterFigures& f, std::size_t filters) {
  const Span s = span_of(f, filters);
  const std::vector<double> h = impulse_response(f.filter, s.count * s.every);
  page::Series impulse{"impulse response", {}}, step{"step response", {}};
  double sum = 0;
  for (std::size_t k = 0; k < h.size(); ++k) {
    sum += h[k];
    if (k % s.every != 0) continue;
    impulse.points.emplace_back(static_cast<double>(k) / f.filter.sample_rate, h[k]);
    step.points.emplace_back(static_cast<double>(k) / f.filter.sample_rate, sum);
  }
  const page::AxisRange time{"time", "s"}, answer{"answer", rate_unit(f.filter.derivative)};
  return figure(page::Plot{"Impulse response of " + f.name,
                           "Answer to a sample of 1 among zeros.",
                           time,
                           answer,
                           {impulse}}) +
         figure(page::Plot{"Step response of " + f.name, "Answer to a step of 1.", time, answer, {step}});
}

std::string norm_rows(const FilterReport& r) {
  TableRows rows;
  for (const FilterFigures& f : r.filters) {
    const std::string unit = rate_unit(f.filter.derivative);
    rows.push_back({f.name, readable(f.norms.h2, unit), readable(f.norms.l1.upper, unit),
                    readable(f.group_delay, "s"), f.bandwidth ? readable(*f.bandwidth, "Hz") : "none",
                    f.settling_time ? readable(*f.settling_time, "s") : "none"});
  }
  return page::table({"filter", "H2 norm (sigma)", "l1 norm (worst case)", "delay", "bandwidth", "settling"},
                     rows);
}

/// Names the quietest and the fastest of many filters of each derivative.
std::string answer_of_many(const FilterReport& r) {
  std::map<int, std::vector<const FilterFigures*>> like;
  for (const FilterFigures& f : r.filters) like[f.filter.derivative].push_back(&f);
  std::string text = "Of " + counted(r.filters.size(), "filter");
  for (const auto& [derivative, filters] : like) {
    const auto quietest = *std::ranges::min_element(
        filters, [](const auto* a, const auto* b) { return a->norms.h2 < b->norms.h2; });
    const auto fastest = *std::ranges::min_element(
        filters, [](const auto* a, const auto* b) { return a->group_delay < b->group_delay; });
    text += (derivative == like.begin()->first ? ", derivative " : "; derivative ") +
            std::to_string(derivative) + ": " + page::isolated(quietest->name) + " has the least noise, " +
            readable(quietest->norms.h2, rate_unit(derivative)) + ", and " + page::isolated(fastest->name) +
            " the least delay, " + readable(fastest->group_delay, "s");
  }
  return text + '.';
}

std::string answer(const FilterReport& r) {
  constexpr std::size_t few = 4;  // in a sentence
  if (r.filters.size() > few) return answer_of_many(r);
  std::string text;
  for (const FilterFigures& f : r.filters) {
    const std::string unit = rate_unit(f.filter.derivative);
    text += (text.empty() ? "" : "; ") + page::isolated(f.name) + " multiplies white noise by " +
            readable(f.norms.h2, unit) + " and the worst case by " + readable(f.norms.l1.upper, unit) +
            ", with a delay of " + readable(f.group_delay, "s");
  }
  return text + '.';
}

}  // namespace

page::Page page_of(const FilterReport& r) {
  using Choices = std::vector<std::pair<std::string, std::string>>;
  Choices filters;
  const std::size_t count = r.filters.size();
  for (const FilterFigures& f : r.filters) {
    filters.emplace_back(f.name, "<div class=\"figures\">" + cutoff_figure(f) + response_figures(f, count) +
                                     answer_figures(f, count) + "</div>");
  }
  page::Page page{"Filters of " + r.spec.file,
                  answer(r),
                  {{"Figures", norm_rows(r)},
                   {"Noise against delay", noise_figures(r)},
                   {"Cut-off and responses", page::choice("Filter", filters)}},
                  r.warnings};
  describe(page, r.spec, verdicts_beside(r.spec));
  return page;
}

}  // namespace qerr
