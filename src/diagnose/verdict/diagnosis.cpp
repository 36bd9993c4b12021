#include "qerr/diagnose/diagnosis.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "core/random.hpp"
#include "core/text.hpp"
#include "diagnose/inference/finding.hpp"
#include "diagnose/inference/tip/tip.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"
#include "diagnose/verdict/cause_report.hpp"
#include "diagnose/verdict/verdict.hpp"
#include "effect/effects/effects.hpp"
#include "kinematics/inverse_dynamics.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

std::string_view name(Verdict v) {
  switch (v) {
    case Verdict::nothing_wrong:
      return "nothing_wrong";
    case Verdict::explained:
      return "explained";
    case Verdict::partly_explained:
      return "partly_explained";
    case Verdict::ambiguous:
      return "ambiguous";
    case Verdict::unexplained:
      return "unexplained";
    case Verdict::cannot_judge:
      return "cannot_judge";
  }
  return "";
}

std::string_view name(DataKind k) {
  switch (k) {
    case DataKind::remark:
      return "remark";
    case DataKind::corrupt:
      return "corrupt";
    case DataKind::missing:
      return "missing";
    case DataKind::repeated:
      return "repeated";
    case DataKind::contradictory:
      return "contradictory";
  }
  return "";
}

std::vector<DataKind> record_faults(const Diagnosis& d) {
  std::set<DataKind> kinds;
  for (const DataFinding& f : d.data)
    if (f.kind != DataKind::remark) kinds.insert(f.kind);
  return {kinds.begin(), kinds.end()};
}

bool is_faultless(const Diagnosis& d) {
  return d.verdict == Verdict::nothing_wrong && record_faults(d).empty() && d.unjudged.empty();
}

namespace {

/// Of a tracked tip each coordinate of a pose is a reading.
constexpr Eigen::Index fewest_rows = 30, fewest_tracked = 45;

/// The columns of a log, without its rows.
Log columns_of(const Log& log) {
  Log columns;
  columns.columns = log.columns;
  columns.misspelt = log.misspelt;
  return columns;
}

Eigen::Index tip_coordinates(const Log& log) {
  Eigen::Index count = 0;
  for (std::size_t i = 0; i < 3; ++i) count += log.find(LogSignal::tip, i).has_value();
  return count;
}

/// The residual noise of a reference that hides all errors worth reporting [counts].
constexpr double hiding_noise = 0.3;

/// Why no reference is usable: the residual noise of each hides all errors worth reporting. Empty if one is
/// usable.
std::optional<std::string> too_noisy(const std::vector<Evidence>& all) {
  double least = std::numeric_limits<double>::infinity(), recorded = 0;
  for (const Evidence& e : all)
    if (e.path_noise / e.step() < least) least = e.path_noise / e.step(), recorded = e.noise / e.step();
  if (all.empty() || least < hiding_noise) return std::nullopt;
  return "the references' noise is " + significant(least, 2) + " counts (" + significant(recorded, 2) +
         " where the path is smooth): 0.3 or less is needed; use a better sensor, or a slower motion at the "
         "same rate";
}

/// Residual noise of the reference of every encoder that has one [counts].
std::map<std::string, double> reference_noise(const std::vector<Evidence>& all) {
  std::map<std::string, double> noise;
  for (const Evidence& e : all) noise[e.joint] = e.path_noise / e.step();
  return noise;
}

/// Whether something is said of a joint or of the tip.
bool is_named(const Diagnosis& d, const std::string& place) {
  return std::any_of(d.causes.begin(), d.causes.end(),
                     [&](const Cause& c) { return c.effect.joint == place; }) ||
         std::any_of(d.unexplained.begin(), d.unexplained.end(),
                     [&](const Unidentified& u) { return u.joint == place; });
}

/// Why nothing can be said of the position of a joint; empty if something can, or if the log does not have
/// the joint.
/// @param recorded  columns of the log as recorded, of which the repair may have dropped some
/// @param noise     of the references [counts]
std::optional<std::string> why_unjudged(std::size_t joint, const Sanity& sane, const Log& recorded,
                                        const std::map<std::string, double>& noise, const TipDiagnosis& tip,
                                        const Diagnosis& d) {
  const std::string& name = sane.model.chain.independent[joint].name;
  const bool misspelt = std::count(recorded.misspelt.begin(), recorded.misspelt.end(), name) > 0;
  const bool read = recorded.find(LogSignal::counts, joint) || recorded.find(LogSignal::measured, joint);
  if (!read) return misspelt ? std::optional("its columns are misspelt") : std::nullopt;
  const bool unseen = std::count(tip.unseen.begin(), tip.unseen.end(), name) > 0;
  if (const auto own = noise.find(name); own != noise.end()) {
    if (own->second < hiding_noise || is_named(d, name)) return std::nullopt;
    return "its reference's noise is " + significant(own->second, 2) + " counts: 0.3 or less is needed";
  }
  if (tip.judged && !unseen) return std::nullopt;
  if (misspelt) return "a column of it is misspelt";
  if (!recorded.find(LogSignal::reference, joint))
    return unseen ? "it has no reference, and does not move the logged tip" : "it has no reference";
  if (!sane.log.find(LogSignal::reference, joint))
    return is_named(d, name) ? std::nullopt : std::optional("its reference cannot be used");
  if (!sane.log.find(LogSignal::counts, joint) && !sane.log.find(LogSignal::measured, joint))
    return is_named(d, name) ? std::nullopt : std::optional("its readings are not fresh");
  return "its encoder feels a joint that has no reference or no reading";
}

/// Adds what the log has columns of and nothing can be said of. Beside a verdict, a warning says why.
void add_unjudged(const Sanity& sane, const Log& recorded, const std::map<std::string, double>& noise,
                  const TipDiagnosis& tip, Diagnosis& d) {
  const auto add = [&](const std::string& place, const std::string& why) {
    d.unjudged.push_back(place);
    if (d.verdict != Verdict::cannot_judge) d.warnings.push_back(place + ": not judged: " + why);
  };
  for (std::size_t i = 0; i < sane.model.chain.independent.size(); ++i)
    if (const auto why = why_unjudged(i, sane, recorded, noise, tip, d))
      add(sane.model.chain.independent[i].name, *why);
  if (!tip.reason.empty()) add("tip", tip.reason);
  for (const char* coordinate : {"tip.x", "tip.y", "tip.z"})
    if (std::count(recorded.misspelt.begin(), recorded.misspelt.end(), coordinate) > 0)
      add(coordinate, "its column is misspelt");
}

/// Compares the record with simulations and collects its evidence, thinned where it is long: as many encoders
/// at a time as have some million rows, so that memory does not grow with their number.
std::vector<Comparison> simulated(const Sanity& sane, const std::vector<Filter>& filters,
                                  const DiagnoseOptions& options, std::vector<Evidence>& all) {
  constexpr std::size_t rows_at_once = 1 << 20;
  const std::vector<std::size_t> encoders = all_encoders(sane.model);
  const bool apart = sane.present.empty() || sane.model.transmission.coupling.is_identity();
  const std::size_t rows = std::max<std::size_t>(1, static_cast<std::size_t>(sane.log.values.rows()));
  const std::size_t at_once = apart ? std::max<std::size_t>(1, rows_at_once / rows) : encoders.size();
  std::vector<JointStatistics> statistics;
  for (std::size_t first = 0; first < encoders.size(); first += at_once) {
    const std::vector<std::size_t> some(
        encoders.begin() + static_cast<std::ptrdiff_t>(first),
        encoders.begin() + static_cast<std::ptrdiff_t>(std::min(first + at_once, encoders.size())));
    std::vector<Evidence> part = evidence(sane, some, options.threads);
    for (JointStatistics& s : joint_statistics(part, filters, options)) statistics.push_back(std::move(s));
    // The same rows of all encoders: of couplings, what one joint adds to another is added row by row.
    for (Evidence& e : part) all.push_back(thinned(std::move(e), stream_seed(options.seed, "thinned")));
  }
  return comparison(statistics);
}

/// Whether the simulated causes leave what the gain says, to a tenth; less than a hundredth of a count is
/// rounding.
bool agrees(const Finding& f) {
  double after = 0, rows = 0;
  for (const HeldOut::Block& b : f.held.blocks) after += b.after, rows += b.rows;
  const double left = std::sqrt(f.simulated.left), step = f.evidence().step();
  double random = 0;  // scatter that was found, which no simulated position has
  for (const ScatterCause& c : f.scatter.causes) random += c.rms * c.rms;
  constexpr double tenth = 1.1, rounding = 0.01;
  return left <= tenth * std::sqrt(std::max(rows > 0 ? after / rows : 0, step * step / 12 + random)) +
                     rounding * step;
}

std::optional<Reproduction> reproduction(const std::vector<std::unique_ptr<Finding>>& findings) {
  if (findings.empty()) return std::nullopt;
  Reproduction all;
  double rows = 0;
  for (const auto& f : findings) {
    const auto n = static_cast<double>(f->evidence().rows());
    all.rms_simulated += n * f->simulated.simulated;
    all.rms_measured += n * f->simulated.measured;
    rows += n;
    all.agrees = all.agrees && agrees(*f);
  }
  all.rms_simulated = std::sqrt(all.rms_simulated / rows);
  all.rms_measured = std::sqrt(all.rms_measured / rows);
  return all;
}

/// Adds the diagnosis of the tip. Its gain is the total gain if no joint has a reference.
void add_tip(const TipDiagnosis& tip, bool joints_judged, Diagnosis& d) {
  if (tip.judged && !joints_judged) {
    d.gain = tip.gain;
    d.reason.clear();
  }
  d.causes.insert(d.causes.end(), tip.causes.begin(), tip.causes.end());
  d.alternatives.insert(d.alternatives.end(), tip.alternatives.begin(), tip.alternatives.end());
  d.unexplained.insert(d.unexplained.end(), tip.unexplained.begin(), tip.unexplained.end());
  d.data.insert(d.data.end(), tip.data.begin(), tip.data.end());
  d.tip_check = tip.check;
  d.warnings.insert(d.warnings.end(), tip.warnings.begin(), tip.warnings.end());
}

/// Lost counts in those of the spec, where readings were judged in the steps that a coarser or wrongly
/// decoded counter has.
void count_as_specified(Cause& cause, const OperationalModel& judged, const OperationalModel& specified) {
  const std::size_t i = independent_index(judged.chain, cause.effect.joint);
  const double per_step =
      judged.transmission.encoders[i].resolution / specified.transmission.encoders[i].resolution;
  if (per_step == 1) return;
  double& counts = cause.effect.numbers.at("counts");
  counts = std::round(counts) * per_step;
  const double within = per_step > 1 ? 0.5 * per_step : 0;  // a step, which says no more
  for (FoundParameter& p : cause.parameters)
    if (p.name == "counts") p = {p.name, counts, p.lower * per_step - within, p.upper * per_step + within};
}

}  // namespace

Diagnosis diagnose(const OperationalModel& model, const std::vector<Filter>& filters,
                   const std::vector<Effect>& present, Log log, const DiagnoseOptions& options) {
  const Log recorded = columns_of(log);
  Sanity sane = check_sanity(model, filters, std::move(log), present);
  Diagnosis d;
  d.causes = sane.causes;
  d.unexplained = std::move(sane.unexplained);
  d.data = std::move(sane.data);
  d.warnings = std::move(sane.warnings);
  d.reason = std::move(sane.cannot_judge);
  const Eigen::Index tracked = tip_coordinates(sane.log);
  const bool enough = sane.log.values.rows() >= fewest_rows;
  const bool tip_enough = tracked > 0 && (enough || tracked * sane.log.values.rows() >= fewest_tracked);
  if (!enough && !tip_enough) {
    const std::string has = "the log has " + counted(static_cast<std::size_t>(sane.log.values.rows()), "row"),
                      remedy = "record " + std::to_string(fewest_rows) +
                               " at the very least, some thousand with the joints in motion";
    d.data.push_back({has, "", 1, {}, remedy});
    d.reason = has + ": " + remedy;
  }
  std::vector<Evidence> all;
  if (enough) d.simulation = simulated(sane, filters, options, all);
  const std::map<std::string, double> noise = reference_noise(all);
  const std::optional<std::string> noisy = too_noisy(all);
  const bool joints_judged = !all.empty();
  if (!has_masses(sane.model.chain))
    for (Evidence& e : all)
      if (has_reversed_effort(e, options.seed)) {
        e.effort *= -1;
        d.data.push_back(sanity::reverse_effort(sane, static_cast<std::size_t>(e.number)));
      }
  // From here on, the first pose and a tracked tip are all that is needed of the log itself.
  if (tracked == 0 && enough) sane.log.values = sane.log.values.topRows<1>().eval();
  const auto findings = findings_of(std::move(all), sane, options);
  std::vector<HeldOut> held;
  for (const auto& finding : findings) {
    const Finding& f = *finding;
    held.push_back(f.held);
    const Gain of_joint = gain({f.held}, options.seed);
    for (Cause& cause : d.causes)
      if (cause.effect.joint == f.evidence().joint && effect_kind(cause.effect.type).action)
        cause.gain = of_joint;
    add(d, f, of_joint);
  }
  for (Cause& cause : d.causes)
    if (cause.effect.type == missed_counts_effect().name) count_as_specified(cause, sane.model, model);
  d.gain = gain(held, options.seed);
  d.check = reproduction(findings);
  for (const AlternativeCause& a : sane.alternatives)
    for (const Cause& c : d.causes)
      if (c.effect.type == a.instead_of && c.effect.joint == a.joint) d.alternatives.push_back(a);
  TipDiagnosis tip;
  if (tip_enough) tip = diagnose_tip(sane.model, sane.present, sane.log, options.seed, options.threads);
  bool judged = joints_judged || tip.judged;
  if (judged && !tip.judged && d.causes.empty() && d.unexplained.empty() && noisy) {
    judged = false;
    d.reason = *noisy;
  }
  if (!judged && !d.causes.empty()) {
    d.gain = d.causes.front().gain;
    d.warnings.push_back("positions are not judged: " + std::exchange(d.reason, ""));
  }
  std::stable_sort(d.causes.begin(), d.causes.end(), [](const Cause& a, const Cause& b) {
    return a.gain.rms_before * a.gain.rms_before - a.gain.rms_after * a.gain.rms_after >
           b.gain.rms_before * b.gain.rms_before - b.gain.rms_after * b.gain.rms_after;
  });
  if (!judged && d.reason.empty()) d.reason = tip.reason;
  add_tip(tip, joints_judged, d);
  d.verdict = verdict(d, judged);
  // What a repaired log shows is no all-clear for the log as it stands.
  if (d.verdict == Verdict::nothing_wrong && !sane.spoilt.empty()) {
    d.verdict = Verdict::cannot_judge;
    d.reason = sane.spoilt + "; after that nothing is wrong";
  }
  add_unjudged(sane, recorded, noise, tip, d);
  return d;
}

}  // namespace qerr
