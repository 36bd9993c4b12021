#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "report/page/bars.hpp"
#include "report/page/envelope.hpp"
#include "report/page/page.hpp"
#include "report/page/plot.hpp"
#include "report/page/prose.hpp"
#include "report/page/waterfall.hpp"
#include "report/simulation/cutoffs.hpp"
#include "report/simulation/page/pictures.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

/// A limit of the magnitude: two lines, at either sign.
page::Series both_signs(const std::string& name, double limit, double from, double to) {
  if (!std::isfinite(limit)) return {name, {}};
  return {name, {{from, limit}, {to, limit}, {NAN, NAN}, {from, -limit}, {to, -limit}}};
}

}  // namespace

std::string prediction_figures(const SimulationReport& r) {
  page::Bars sigma{
      "Simulated sigma over IPQN along the path",
      "Sigma of the simulated error as a part of the sigma of the theory, with its 95 % interval.",
      {}};
  page::Bars peak{"Peak over worst case along the path",
                  "Largest simulated error as a part of the largest possible one.",
                  {}};
  for (const NamedSignal& named : signals_of(r)) {
    const SimulatedSignal& s = named.signal;
    if (s.sigma_ipqn_path > 0 && std::isfinite(s.sigma_ipqn_path) && !is_constant(s)) {
      const double ratio = s.sigma_simulated / s.sigma_ipqn_path;
      page::Bar bar{page::isolated_runs(label_of(named)), ratio, significant(ratio, 3)};
      const double lower = s.sigma_lower / s.sigma_ipqn_path, upper = s.sigma_upper / s.sigma_ipqn_path;
      if (std::isfinite(lower) && std::isfinite(upper)) bar.error = {std::max(lower, 0.0), upper};
      sigma.bars.push_back(bar);
    }
    if (s.worst_case_path > 0 && std::isfinite(s.worst_case_path)) {
      const double part = s.peak_simulated / s.worst_case_path;
      peak.bars.push_back({page::isolated_runs(label_of(named)), part, percent(part)});
    }
  }
  std::string out;
  for (const page::Bars* bars : {&sigma, &peak})
    if (!bars->bars.empty()) out += figure(*bars);
  return page::side_by_side(out);
}

std::string error_figure(const NamedSignal& s, const ErrorTrace& trace, const std::vector<double>& error,
                         std::size_t intervals) {
  if (error.empty()) return "";
  const double first = trace.first_time,
               last = first + static_cast<double>(error.size() - 1) / trace.sample_rate;
  page::Envelope line(first, last, intervals);
  for (std::size_t k = 0; k < error.size(); ++k)
    line.add(first + static_cast<double>(k) / trace.sample_rate, error[k]);
  page::Plot plot{page::isolated_runs("Error of " + label_of(s) + " in time"),
                  "Smallest and largest error in each interval of the first run, inside the worst case and "
                  "sigma along the path.",
                  page::time_axis(last),
                  {"error", s.shown_unit},
                  {{"error", line.points()}}};
  for (const page::Series& limit :
       {both_signs("worst case along the path", s.signal.worst_case_path, first, last),
        both_signs("sigma, IPQN along the path", s.signal.sigma_ipqn_path, first, last)})
    if (!limit.points.empty()) plot.series.push_back(limit);
  return figure(plot);
}

std::string ladder_figure(const NamedSignal& s) {
  const Json factors = json_of(s.signal.ladder);
  if (is_unbounded(s.signal) || is_constant(s.signal) || !(s.signal.sigma_ipqn > 0)) return "";
  page::Waterfall w{page::isolated_runs("From IPQN to the simulated sigma of " + label_of(s)),
                    "The theory at the centre of the motion times each factor is the simulated sigma.",
                    "IPQN at the centre of the motion",
                    "simulated sigma",
                    s.signal.sigma_ipqn,
                    s.shown_unit,
                    {}};
  for (const auto& [name, value] : factors.members()) {
    std::string words = name;
    std::replace(words.begin(), words.end(), '_', ' ');
    w.factors.push_back({words, value.number().value_or(NAN)});
  }
  return figure(w);
}

std::string cutoff_figures(const SimulationReport& r) {
  if (!r.cutoffs) return "";
  const std::vector<CutoffChoice> choices = cutoff_choices(r);
  const std::string unit = cutoff_unit(r);
  page::Series noise{"encoder error", {}}, tracking{"tracking error", {}}, total{"total", {}, true};
  std::vector<std::vector<std::string>> rows;
  for (const CutoffChoice& c : choices) {
    noise.points.emplace_back(c.cutoff, c.noise);
    tracking.points.emplace_back(c.cutoff, c.tracking);
    total.points.emplace_back(c.cutoff, c.total);
    rows.push_back({readable(c.cutoff, "Hz"), readable(c.noise, unit), readable(c.tracking, unit),
                    readable(c.total, unit)});
  }
  const CutoffChoice& best = choices[best_of(choices)];
  const page::Plot plot{
      "Error over the cut-off",
      "Root mean square errors along the motion: by the encoders, by the filter, and of both.",
      {"cut-off", "Hz", true},
      {"error, rms", unit, true},
      {noise, tracking, total},
      {{"least total", best.cutoff}}};
  return page::side_by_side(figure(plot)) +
         page::isolated_table({"cut-off", "encoder error", "tracking error", "total"}, rows);
}

}  // namespace qerr
