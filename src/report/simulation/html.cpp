#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/text.hpp"
#include "report/analysis/effects.hpp"
#include "report/analysis/figures.hpp"
#include "report/analysis/tables.hpp"
#include "report/formats.hpp"
#include "report/page/page.hpp"
#include "report/simulation/parts.hpp"
#include "report/text_table.hpp"
#include "simulate/motion_path.hpp"

namespace qerr {

namespace {

/// A quarter of the values, so that seven sections or more are averaged.
std::size_t section_length(std::size_t values) {
  constexpr std::size_t longest = 4096;
  return std::min(longest, std::bit_floor(values / 4));
}

/// A limit of the magnitude: two lines, at either sign.
page::Series both_signs(const std::string& name, double limit, double from, double to) {
  if (!std::isfinite(limit)) return {name, {}};
  return {name, {{from, limit}, {to, limit}, {NAN, NAN}, {from, -limit}, {to, -limit}}};
}

/// Simulated sigmas as parts of the predicted ones.
std::string prediction_figure(const SimulationReport& r) {
  page::Bars sigma{
      "Simulated sigma over IPQN along the path",
      "Sigma of the simulated error as a part of the sigma of the theory, with its 95 % interval.",
      {},
      {""},
      1};
  for (const NamedSignal& named : signals_of(r)) {
    const SimulatedSignal& s = named.signal;
    if (s.sigma_ipqn_path > 0 && std::isfinite(s.sigma_ipqn_path) && !is_constant(s)) {
      const double ratio = s.sigma_simulated / s.sigma_ipqn_path;
      page::Bar bar{page::isolated_runs(label_of(named)), ratio, significant(ratio, 3)};
      const double lower = s.sigma_lower / s.sigma_ipqn_path, upper = s.sigma_upper / s.sigma_ipqn_path;
      if (std::isfinite(lower) && std::isfinite(upper)) bar.error = {std::max(lower, 0.0), upper};
      sigma.bars.push_back(bar);
    }
  }
  return sigma.bars.empty() ? "" : figure(sigma);
}

/// The path of the tip in three views, its ends marked; of a robot whose tip moves by translation.
std::string path_figures(const SimulationReport& r) {
  const Motion& motion = *r.spec.motion;
  const MotionPath path(motion);
  constexpr int points = 150;
  std::vector<Eigen::Vector3d> tips;
  for (int i = 0; i <= points; ++i)
    tips.push_back(
        forward_kinematics(r.spec.model.chain, path.position(motion.duration * i / points)).translation());
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& tip : tips) box.extend(tip);
  if (!(box.diagonal().norm() > 0)) return "";
  constexpr std::array<const char*, 3> axes{"x", "y", "z"};
  std::string views;
  for (const auto& [a, b] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
    if (!(box.sizes()[a] > 0 || box.sizes()[b] > 0)) continue;
    page::Series line{"path", {}};
    for (const Eigen::Vector3d& tip : tips) line.points.emplace_back(tip[a], tip[b]);
    const std::string x = axes[a], y = axes[b];
    page::Series begin{"begin", {line.points.front()}, true, false},
        end{"end", {line.points.back()}, true, false};
    page::Plot plot{"Path of the tip, view " + x + y,
                    "Where the tip is along the motion, in the base frame.",
                    {x, "m", false, false},
                    {y, "m", false, false},
                    {std::move(line), std::move(begin), std::move(end)}};
    plot.equal_scales = true;
    views += figure(plot);
  }
  return page::side_by_side(views);
}

/// The error of a signal in time inside its bounds.
/// @param trace      of the signal's filter
/// @param intervals  of the line
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

/// Errors over the cut-off. @pre the report has `cutoffs`
std::string cutoff_figures(const SimulationReport& r) {
  const std::vector<CutoffChoice> choices = cutoff_choices(r);
  const std::string unit = cutoff_unit(r);
  page::Series noise{"encoder error", {}}, tracking{"tracking error", {}}, total{"total", {}, true};
  TableRows rows;
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
         page::table({"cut-off", "encoder error", "tracking error", "total"}, rows);
}

/// Root of the mean square in each of equal intervals of the frequency's logarithm, at its mean frequency.
std::vector<std::pair<double, double>> in_intervals(const std::vector<std::pair<double, double>>& density,
                                                    std::size_t intervals) {
  std::vector<std::pair<double, double>> all;
  if (density.size() < 2) return density;
  const double first = std::log(density.front().first),
               width = (std::log(density.back().first) - first) / static_cast<double>(intervals);
  for (std::size_t i = 0; i < density.size();) {
    const double end = first + width * (std::floor((std::log(density[i].first) - first) / width + 1e-9) + 1);
    double frequency = 0, square = 0, count = 0;
    for (; i < density.size() && (count == 0 || std::log(density[i].first) < end - 1e-9 * width); ++i) {
      frequency += density[i].first;
      square += density[i].second * density[i].second;
      ++count;
    }
    all.emplace_back(frequency / count, std::sqrt(square / count));
  }
  return all;
}

/// Spectral density of the error beside that of white errors of the theory's sigma behind the filter.
/// @param position  the same coordinate without a filter
/// @param filter    null: none
std::string spectrum_figure(const NamedSignal& s, const SimulatedSignal& position, const Filter* filter,
                            const ErrorTrace& trace, const std::vector<double>& error,
                            std::size_t intervals) {
  page::Series simulated{"simulated", in_intervals(amplitude_density(error, trace.sample_rate), intervals)};
  if (simulated.points.empty() || is_constant(s.signal)) return "";
  page::Series white{"white (IPQN)", {}};
  double largest = 0;
  for (const auto& [frequency, density] : simulated.points) largest = std::max(largest, density);
  for (const auto& [frequency, density] : simulated.points) {
    const double gain = filter ? std::abs(response(*filter, frequency)) : 1;
    white.points.emplace_back(frequency, position.sigma_ipqn_path * std::sqrt(2 / trace.sample_rate) * gain);
    largest = std::max(largest, white.points.back().second);
  }
  // Zeros of a response would stretch the logarithmic axis without bound.
  for (page::Series* series : {&simulated, &white})
    std::erase_if(series->points, [&](const auto& p) { return !(p.second >= 1e-6 * largest); });
  page::Plot plot{page::isolated_runs("Spectrum of " + label_of(s)),
                  "Amplitude spectral density of the simulated error, beside that of white errors with the "
                  "sigma of the theory behind the filter.",
                  {"frequency", "Hz", true},
                  {"density", (s.shown_unit.empty() ? "1" : s.shown_unit) + "/sqrt(Hz)", true},
                  {simulated}};
  if (!white.points.empty()) plot.series.push_back(white);
  return figure(plot);
}

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
  if (!r.spec.model.tips && r.spec.model.coordinates.empty())
    return "Only coordinates of the tip are compared, and the spec has none of them.";
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
  TableRows sigmas;
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

std::string tracking_rows(const SimulationReport& r) {
  const TableRows rows = tracking_cells(r);
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

std::vector<std::pair<double, double>> amplitude_density(const std::vector<double>& values, double rate) {
  if (values.size() < 32) return {};
  const std::size_t length = section_length(values.size());
  double mean = 0;
  for (const double v : values) mean += v / static_cast<double>(values.size());
  std::vector<double> window(length), power(length / 2 + 1, 0.0), section(length);
  double window_square = 0;
  for (std::size_t k = 0; k < length; ++k) {
    window[k] =
        0.5 - 0.5 * std::cos(2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(length));
    window_square += window[k] * window[k];
  }
  double sections = 0;
  for (std::size_t from = 0; from + length <= values.size(); from += length / 2, ++sections) {
    for (std::size_t k = 0; k < length; ++k) section[k] = window[k] * (values[from + k] - mean);
    const auto spectrum = half_spectrum(section);
    for (std::size_t n = 0; n < power.size(); ++n) power[n] += std::norm(spectrum[n]);
  }
  std::vector<std::pair<double, double>> density;
  for (std::size_t n = 1; n < power.size(); ++n) {
    // Of a real signal, each frequency but the last one stands twice in the transform.
    const double sides = n + 1 == power.size() ? 1 : 2;
    density.emplace_back(static_cast<double>(n) * rate / static_cast<double>(length),
                         std::sqrt(sides * power[n] / (sections * rate * window_square)));
  }
  return density;
}

page::Page page_of(const SimulationReport& r) {
  page::Page page{"Simulation of " + r.spec.robot_name,
                  r.cutoffs ? cutoff_answer(r) : simulation_answer(r),
                  {},
                  r.warnings};
  describe(page, r.spec, verdicts_beside(r.spec));
  page.add("The simulation", page::paragraph(counted(r.simulation.runs, "run") + " of " +
                                             counted(r.simulation.samples, "sample") + ", the first " +
                                             std::to_string(r.simulation.settling) + " discarded.") +
                                 page::list(simulated_effects(r.spec)));
  if (r.cutoffs) {
    page.add("Cut-offs of " + r.cutoffs->filter, cutoff_figures(r));
    return page;
  }
  if (!r.estimators.empty()) {
    page.answer = "Along the motion estimator " + page::isolated(r.estimators.front().estimator) +
                  " has the least error of joint " +
                  page::isolated(r.spec.model.chain.independent[r.estimators.front().joint].name) + ", " +
                  readable(r.estimators.front().rms, speed_unit(r, r.estimators.front())) + " rms.";
    page.add("Velocity estimators", estimator_figures(r));
    return page;
  }
  if (r.spec.model.coordinates.empty()) return page;
  page.add("Simulation and theory", page::side_by_side(prediction_figure(r) + "<div>" +
                                                       page::table(factor_cells(r), "sigma of") + "</div>") +
                                        deviation_list(r));
  page.add("Path of the tip", path_figures(r));
  const auto signals = std::ssize(page.sections);
  page.add("All figures", figure_tables(r));
  page.add("Errors of the estimates, by the encoders and by the filter", tracking_rows(r));
  if (std::string figures = signal_figures(r, page::bytes_left(page)); !figures.empty())
    page.sections.insert(page.sections.begin() + signals,
                         {"Errors in time, and their spectrum", std::move(figures)});
  return page;
}

}  // namespace qerr
