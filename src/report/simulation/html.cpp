#include <algorithm>
#include <cmath>
#include <utility>

#include "core/text.hpp"
#include "report/analysis/about.hpp"
#include "report/analysis/effects.hpp"
#include "report/analysis/requirements.hpp"
#include "report/formats.hpp"
#include "report/page/page.hpp"
#include "report/page/prose.hpp"
#include "report/simulation/cutoffs.hpp"
#include "report/simulation/estimators.hpp"
#include "report/simulation/page.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

/// Smallest and largest of some values as text: `0.93 to 1.08`; "" without any.
class RatioRange {
 public:
  void add(double value) { least_ = std::min(least_, value), largest_ = std::max(largest_, value); }
  bool empty() const { return !(least_ <= largest_); }
  double largest() const { return largest_; }
  std::string text() const {
    const std::string from = significant(least_, 3), to = significant(largest_, 3);
    return from == to ? from : from + " to " + to;
  }

 private:
  double least_ = INFINITY, largest_ = -INFINITY;
};

std::string cutoff_answer(const SimulationReport& r) {
  const std::vector<CutoffChoice> choices = cutoff_choices(r);
  const std::size_t best = best_of(choices);
  const bool at_end = best == 0 || best + 1 == choices.size();
  return "Filter " + page::isolated(r.cutoffs->filter) + " has the least error along the motion, " +
         readable(choices[best].total, cutoff_unit(r)) + " rms, with a cut-off of " +
         readable(choices[best].cutoff, "Hz") + (at_end ? ", which is an end of the range: widen it." : ".");
}

std::string simulation_answer(const SimulationReport& r) {
  if (r.spec.model.tips)
    return "Of several tips none is compared: with one robot.tip its errors along the motion are here.";
  RatioRange sigma, peak;
  for (const NamedSignal& named : signals_of(r)) {
    const SimulatedSignal& s = named.signal;
    if (s.sigma_ipqn > 0 && std::isfinite(s.sigma_ipqn) && !is_constant(s))
      sigma.add(s.sigma_simulated / s.sigma_ipqn);
    if (s.worst_case_path > 0 && std::isfinite(s.worst_case_path))
      peak.add(s.peak_simulated / s.worst_case_path);
  }
  std::string text = "Along the motion ";
  text += sigma.empty()
              ? "all errors are constant"
              : "the simulated sigma is " + sigma.text() + " times IPQN at the centre of the motion";
  if (!peak.empty()) text += ", and no error exceeds " + percent(peak.largest()) + " of its worst case";
  return text + '.';
}

/// Two tables, which fit a printed page.
std::string figure_tables(const SimulationReport& r) {
  std::vector<std::vector<std::string>> sigmas;
  std::vector<std::string> peaks;
  for (const NamedSignal& named : signals_of(r)) {
    const SimulatedSignal& s = named.signal;
    const auto text = [&](double value) { return readable(value, named.shown_unit); };
    const std::string name = label_of(named);
    sigmas.push_back({name, text(s.sigma_simulated), text(s.sigma_lower) + " .. " + text(s.sigma_upper),
                      text(s.sigma_ipqn), text(s.sigma_ipqn_path), text(s.sigma_exact)});
    const bool bounded = s.worst_case_path > 0 && std::isfinite(s.worst_case_path);
    peaks.push_back(page::cell(page::isolated_runs(name)) + page::cell(text(s.mean_simulated)) +
                    (bounded ? page::bar_cell(text(s.peak_simulated), s.peak_simulated / s.worst_case_path,
                                              s.peak_simulated)
                             : page::cell(text(s.peak_simulated))) +
                    page::cell(text(s.worst_case)) + page::cell(text(s.worst_case_path)));
  }
  return page::table({"sigma of", "simulated", "95 % interval", "IPQN at the centre", "IPQN along the path",
                      "exact at its speeds"},
                     sigmas) +
         page::table_of("peaks",
                        {"error of", "mean", "peak (bar: of its worst case)", "worst case at the centre",
                         "worst case along the path"},
                        peaks);
}

/// From IPQN to the simulated sigma, factor by factor.
std::string factor_table(const SimulationReport& r) {
  std::vector<std::vector<std::string>> rows = factor_cells(r);
  std::vector<std::string> header = rows.front();
  header.front() = "sigma of";
  rows.erase(rows.begin());
  return page::table(header, rows);
}

std::string tracking_rows(const SimulationReport& r) {
  const std::vector<std::vector<std::string>> rows = tracking_cells(r);
  if (rows.empty()) return "";
  return page::table({"estimate", "encoder error, rms", "tracking error, rms", "its peak", "total, rms"},
                     rows);
}

std::string deviation_list(const SimulationReport& r) {
  const std::vector<IpqnDeviation> all = ipqn_deviations(r);
  if (all.empty()) return page::paragraph("IPQN at the centre of the motion is within 5 % everywhere.");
  std::vector<std::string> items;
  for (const auto& [why, signals] : all) items.push_back(why + ": " + signals);
  return page::paragraph("IPQN at the centre of the motion is off by more than 5 %, mostly because") +
         page::list(items);
}

/// How many signals are drawn, and the intervals of their lines.
struct SignalExtent {
  std::size_t signals, of_time, of_spectrum;
};

SignalExtent signal_extent(std::size_t bytes, std::size_t signals) {
  // Axes and legends of a signal's figures; one point; the coarsest lines.
  constexpr std::size_t fixed = 6300, per_point = 35, of_time = 26, of_spectrum = 14;
  constexpr std::size_t least = fixed + per_point * 2 * (of_time + of_spectrum);
  const std::size_t drawn = std::clamp<std::size_t>(bytes / least, 1, signals);
  const std::size_t points = std::max(bytes / drawn, least) / per_point - fixed / per_point;
  const std::size_t spectrum = std::clamp<std::size_t>(points / 6, of_spectrum, 120);
  return {drawn, std::clamp<std::size_t>(points / 2 - spectrum, of_time, 320), spectrum};
}

/// Draws each signal: error in time, spectrum.
std::string signal_figures(const SimulationReport& r, std::size_t bytes) {
  if (r.simulation.traces.empty()) return "";
  const std::vector<NamedSignal> signals = signals_of(r);
  if (signals.empty()) return "";
  const auto [drawn, of_time, of_spectrum] = signal_extent(bytes, signals.size());
  const std::size_t coordinates = r.spec.model.coordinates.size();
  std::vector<std::pair<std::string, std::string>> all;
  for (std::size_t i = 0; i < drawn; ++i) {
    const std::size_t output = i / coordinates, c = i % coordinates;
    const ErrorTrace& trace = r.simulation.traces[output];
    const std::vector<double>& error = trace.error[c];
    const Filter* filter = output > 0 ? &r.spec.filters[output - 1].filter : nullptr;
    all.emplace_back(label_of(signals[i]),
                     page::side_by_side(error_figure(signals[i], trace, error, of_time) +
                                        spectrum_figure(signals[i], r.simulation.results[0][c], filter, trace,
                                                        error, of_spectrum)));
  }
  std::string out = page::paragraph(
      "The first run, from the end of the settling on: the line passes through the smallest and the largest "
      "value of each interval.");
  const Simulation& s = r.simulation;
  if (const std::size_t kept = s.traces[0].error.empty() ? 0 : s.traces[0].error[0].size();
      kept < s.samples - s.settling)
    out += page::paragraph("Drawn are " + std::to_string(kept) + " of " +
                           std::to_string(s.samples - s.settling) + " samples.");
  if (drawn < signals.size())
    out += page::paragraph("Drawn are the first " + std::to_string(drawn) + " of " +
                           std::to_string(signals.size()) + " signals; the table below has all.");
  return out + page::choice("Signal", all);
}

/// What the simulated robot has beyond quantization: `backlash of a4: gap 200 urad`.
std::vector<std::string> simulated_effects(const Spec& spec) {
  std::vector<std::string> all;
  for (const Effect& e : spec.effects)
    all.push_back(e.type + (e.joint.empty() ? "" : " of " + e.joint) + ": " + parameters_text(spec, e));
  return all;
}

}  // namespace

page::Page page_of(const SimulationReport& r) {
  page::Page page{"Simulation of " + r.spec.robot_name,
                  r.cutoffs ? cutoff_answer(r) : simulation_answer(r),
                  {},
                  r.warnings};
  describe(page, r.spec, verdicts_beside(r.spec));
  const auto add = [&](const std::string& heading, const std::string& body) {
    if (!body.empty()) page.sections.push_back({heading, body});
  };
  add("The simulation",
      page::paragraph(counted(r.simulation.runs, "run") + " of " + counted(r.simulation.samples, "sample") +
                      ", the first " + std::to_string(r.simulation.settling) + " discarded.") +
          page::list(simulated_effects(r.spec)));
  if (r.cutoffs) {
    add("Cut-offs of " + r.cutoffs->filter, cutoff_figures(r));
    return page;
  }
  if (!r.estimators.empty()) {
    page.answer = "Along the motion estimator " + page::isolated(r.estimators.front().estimator) +
                  " has the least error of joint " +
                  page::isolated(r.spec.model.chain.independent[r.estimators.front().joint].name) + ", " +
                  readable(r.estimators.front().rms, speed_unit(r, r.estimators.front())) + " rms.";
    add("Velocity estimators", estimator_figures(r));
    return page;
  }
  if (r.spec.model.tips) return page;
  add("Simulation and theory",
      page::side_by_side(prediction_figure(r) + "<div>" + factor_table(r) + "</div>") + deviation_list(r));
  add("Path of the tip", path_figures(r));
  const auto signals = static_cast<std::ptrdiff_t>(page.sections.size());
  add("All figures", figure_tables(r));
  add("Errors of the estimates, by the encoders and by the filter", tracking_rows(r));
  if (std::string figures = signal_figures(r, page::bytes_left(page)); !figures.empty())
    page.sections.insert(page.sections.begin() + signals,
                         {"Errors in time, and their spectrum", std::move(figures)});
  return page;
}

}  // namespace qerr
