#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <numbers>

#include "core/text.hpp"
#include "report/analysis/about.hpp"
#include "report/analysis/requirements.hpp"
#include "report/filter/pictures.hpp"
#include "report/formats.hpp"
#include "report/page/plot.hpp"
#include "report/page/prose.hpp"

namespace qerr {

namespace {

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
  std::vector<std::vector<std::string>> rows;
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
    const auto quietest = *std::min_element(filters.begin(), filters.end(), [](const auto* a, const auto* b) {
      return a->norms.h2 < b->norms.h2;
    });
    const auto fastest = *std::min_element(filters.begin(), filters.end(), [](const auto* a, const auto* b) {
      return a->group_delay < b->group_delay;
    });
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
