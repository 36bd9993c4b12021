#include "diagnose/inference/tip/tip.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/random.hpp"
#include "core/solve.hpp"
#include "core/statistics.hpp"
#include "core/text.hpp"
#include "diagnose/inference/tip/tip_remainder.hpp"
#include "diagnose/inference/tip/tip_select.hpp"
#include "diagnose/inference/tip/tip_weight.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/kinematics/chain.hpp"
#include "simulate/sensing.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index folds = 5;
constexpr int resamples = 400;

/// Parameters of an effect computed from its coefficients, with 95 % intervals (delta method).
std::vector<FoundParameter> parameters(const Term& term, const Eigen::VectorXd& c,
                                       const Eigen::MatrixXd& covariance) {
  Effect fitted = term.effect;
  term.fill(fitted, c);
  std::vector<FoundParameter> found;
  for (const auto& [name, value] : fitted.numbers) {
    Eigen::VectorXd slope(c.size());
    for (Eigen::Index i = 0; i < c.size(); ++i) {
      const double h = 1e-4 * std::max(c.norm(), 1e-300);
      Effect up = term.effect, down = term.effect;
      term.fill(up, c + h * Eigen::VectorXd::Unit(c.size(), i));
      term.fill(down, c - h * Eigen::VectorXd::Unit(c.size(), i));
      slope[i] = (up.number(name) - down.number(name)) / (2 * h);
    }
    const double half = 1.96 * std::sqrt(std::max(0.0, slope.dot(covariance * slope)));
    found.push_back({name, value, value - half, value + half});
  }
  return found;
}

/// Residuals of contiguous blocks under a model, with its nuisance terms, that was fitted to the other
/// blocks.
/// @param tracker  whether displacements of the tracker are subtracted: no model of the machine has them
Eigen::VectorXd held_out(const TipModel& m, bool tracker) {
  Eigen::VectorXd left = m.entries();
  const Eigen::MatrixXd x = m.all_columns();
  if (x.cols() == 0) return left;
  const Eigen::VectorXd root = m.solution().weight.cwiseSqrt();
  const auto coordinates = static_cast<Eigen::Index>(m.evidence().axes.size());
  const Eigen::Index rows = left.size() / coordinates;
  const Eigen::Index blocks = std::max(folds, std::min<Eigen::Index>(20, rows / 10));
  Eigen::VectorXd scale = x.colwise().norm();
  for (double& s : scale) s = s > 0 ? 1 / s : 0;
  const Eigen::MatrixXd unit = root.asDiagonal() * x * scale.asDiagonal();
  for (Eigen::Index fold = 0; fold < folds; ++fold) {
    std::vector<Eigen::Index> in, out;
    for (Eigen::Index i = 0; i < m.entries().size(); ++i)
      (((i / coordinates) * blocks / rows) % folds == fold ? out : in).push_back(i);
    const Eigen::VectorXd target = root.cwiseProduct(m.entries())(in);
    Eigen::VectorXd theta = scale.asDiagonal() * least_norm_solution(unit(in, Eigen::all), target, 1e-6);
    for (std::size_t i = 0; i < m.terms().size(); ++i)
      if (!tracker && m.terms()[i].of_record()) theta.segment(m.position(i), m.terms()[i].size()).setZero();
    left(out) = m.entries()(out) - x(out, Eigen::all) * theta;
  }
  return left;
}

/// 95 % interval of the ratio of the rms before and after, by a bootstrap over blocks.
void ratio_interval(const Eigen::VectorXd& without, const Eigen::VectorXd& with, const TipModel& m,
                    Gain& gain) {
  const auto coordinates = static_cast<Eigen::Index>(m.evidence().axes.size());
  const std::uint64_t seed = stream_seed(m.seed(), "tip bootstrap");
  const Eigen::Index rows = without.size() / coordinates;
  const Eigen::Index blocks = std::min<Eigen::Index>(50, rows / 2);
  Eigen::ArrayXd before(blocks), after(blocks);
  for (Eigen::Index b = 0; b < blocks; ++b) {
    const Eigen::Index first = b * rows / blocks * coordinates, end = (b + 1) * rows / blocks * coordinates;
    before[b] = without.segment(first, end - first).squaredNorm();
    after[b] = with.segment(first, end - first).squaredNorm();
  }
  std::vector<double> ratios;
  for (std::uint64_t r = 0; r < resamples; ++r) {
    double sum_before = 0, sum_after = 0;
    for (Eigen::Index b = 0; b < blocks; ++b) {
      const auto block = static_cast<Eigen::Index>(
          unit_interval(random_bits(seed, r, static_cast<std::uint64_t>(b))) * static_cast<double>(blocks));
      sum_before += before[block];
      sum_after += after[block];
    }
    ratios.push_back(std::sqrt(sum_before / std::max(sum_after, 1e-300)));
  }
  std::sort(ratios.begin(), ratios.end());
  gain.lower = ratios[resamples / 40];
  gain.upper = ratios[resamples - 1 - resamples / 40];
}

/// @param ideal  the model without causes and frames
Gain gain_of(const TipModel& m, const TipModel& ideal) {
  const Eigen::VectorXd before = held_out(ideal, false), after = held_out(m, false);
  Gain gain;
  gain.unit = "m";
  gain.of_tip = true;
  gain.rms_before = rms(before);
  gain.rms_after = rms(after);
  gain.held_out = true;
  ratio_interval(before, after, m, gain);
  const Eigen::VectorXd scaled = m.solution().weight.cwiseSqrt().cwiseProduct(after);
  gain.sigma_ratio = rms(scaled);
  gain.coverage = static_cast<double>((scaled.array().abs() < 1.96).count()) /
                  static_cast<double>(std::max<Eigen::Index>(scaled.size(), 1));
  std::vector<std::size_t> all(m.terms().size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  gain.log_score = (m.solution().log_likelihood - m.trial(all, {}).log_likelihood) /
                   static_cast<double>(m.entries().size());
  return gain;
}

/// The model without causes and frames, with the displacements of the tracker that were found beside them.
TipModel without_causes(const TipModel& found, TipModel ideal) {
  for (std::size_t i = 0; i < found.terms().size(); ++i)
    if (found.terms()[i].of_record()) ideal.add(found.terms()[i], found.coefficients(i));
  ideal.fit();
  return ideal;
}

/// Whether causes and frames reduce the residual of held-out blocks, by an interval of the ratio without 1.
/// What does not is no error that anyone would notice, however significant it seems to be.
bool improves(const TipModel& found, const TipModel& alone) {
  if (found.terms().size() == alone.terms().size() && found.frames() == UnknownFrames{}) return true;
  Gain gain;
  ratio_interval(held_out(alone, true), held_out(found, true), found, gain);
  return gain.lower > 1;
}

/// The extended model along the record: its tip at the readings less the causes' additions, rows x logged
/// coordinates [m].
Eigen::MatrixXd simulated_tip(const OperationalModel& model, const TipModel& m) {
  const TipEvidence& e = m.evidence();
  const Eigen::VectorXd mean = mean_errors(model.transmission);
  Eigen::MatrixXd tips(e.rows(), e.tip.rows());
  for (Eigen::Index k = 0; k < e.rows(); ++k) {
    const TipPose p = m.estimate().pose(e, k);
    tips.row(k) = (p.tip - p.encoders * mean)(e.axes).transpose();
  }
  return tips;
}

/// What the simulation leaves of what was tracked, beside the zeros of encoders, which are free unless they
/// are known.
Eigen::MatrixXd left_by_simulation(const TipModel& m, const Eigen::MatrixXd& simulated) {
  Eigen::MatrixXd residual = simulated - m.evidence().tip.transpose();
  if (m.nuisance() == 0) return residual;
  Eigen::MatrixXd free(residual.size(), m.nuisance());
  const Eigen::MatrixXd columns = m.all_columns();
  for (Eigen::Index i = 0; i < free.cols(); ++i) free.col(i) = m.in_base(columns.col(i)).reshaped();
  residual.reshaped() -= free * least_norm_solution(free, residual.reshaped());
  return residual;
}

/// @param without  rms of the model without causes less what was tracked
Reproduction reproduction(const OperationalModel& model, const TipModel& m, const Eigen::MatrixXd& simulated,
                          const Eigen::MatrixXd& left, double without, const Gain& gain) {
  const TipEvidence& e = m.evidence();
  double moved = 0;
  for (Eigen::Index k = 0; k < e.rows(); ++k)
    moved += (tracked_tip(model.chain, e.joints.col(k)).translation()(e.axes) - simulated.row(k).transpose())
                 .squaredNorm();
  const double floor = std::pow(m.solution().sigma, 2) + m.quantization();
  constexpr double tenth = 1.1;
  return {std::sqrt(moved / static_cast<double>(e.tip.size()) + floor), without,
          rms(left.reshaped()) <= tenth * std::max(gain.rms_after, std::sqrt(floor))};
}

/// Mean square per coordinate that the causes explain [m^2].
double explained(const Gain& gain) { return std::pow(gain.rms_before, 2) - std::pow(gain.rms_after, 2); }

/// Whether what remains has more of a structure than the causes explain: they are its share in their columns
/// then.
bool outweighs(const Unidentified& left, const Gain& gain) {
  return 0.5 * left.amplitude * left.amplitude > explained(gain);
}

/// Whether errors in time displace the tip by many times what all causes explain together: no machine has
/// faults that cancel so well. Dimensions that a record does not tell apart may.
bool cancel(const TipModel& m, double without) {
  constexpr double times = 20;  // convention
  for (std::size_t i = 0; i < m.terms().size(); ++i)
    if (const TipTerm& t = m.terms()[i];
        !t.kinematic() && !t.of_record() && rms((m.columns(i) * m.coefficients(i)).array()) > times * without)
      return true;
  return false;
}

/// Whether what remains beside causes may be theirs: the fit is linear in the encoders' errors, and leaves up
/// to a tenth of their size.
bool is_linearization(const Unidentified& left, const Gain& gain) {
  return 0.5 * left.amplitude * left.amplitude < 0.01 * explained(gain);
}

/// What to record to distinguish two causes.
std::string record(const TipAlternative& a, const TipTerm& chosen) {
  if (a.everywhere) return "no pose distinguishes them: measure the link or the joint's zero directly";
  if (chosen.kinematic() && a.other.kinematic() && a.other.term.effect.joint == chosen.term.effect.joint)
    return "poses in which " + chosen.term.effect.joint + " moves through a wider range";
  if (chosen.kinematic() && a.other.kinematic())
    return "poses in which " + a.other.term.effect.joint + " and " + chosen.term.effect.joint +
           " move through wider ranges";
  return "a better sensor on " + chosen.term.effect.joint + ", or wider motions at several speeds";
}

/// Adds what is not among them: dimensions along several axes, and orders, are one effect of a joint.
void add_alternative(TipDiagnosis& d, AlternativeCause a) {
  if (std::none_of(d.alternatives.begin(), d.alternatives.end(), [&](const AlternativeCause& b) {
        return a.instead_of == b.instead_of && a.effect == b.effect && a.joint == b.joint;
      }))
    d.alternatives.push_back(std::move(a));
}

void name_causes(const TipSelection& s, TipDiagnosis& d) {
  const TipModel& m = s.model;
  std::vector<std::pair<double, Cause>> causes;
  for (std::size_t i = 0; i < m.terms().size(); ++i) {
    const TipTerm& t = m.terms()[i];
    if (t.of_record()) {
      d.unexplained.push_back(tracker_finding(m, i));
      continue;
    }
    const Eigen::VectorXd c = m.coefficients(i);
    Effect effect = t.term.effect;
    t.term.fill(effect, c);
    if (!t.term.named()) {
      Unidentified u{effect.joint, t.term.unnamed, {}, {}, effect.number_or("amplitude", 0)};
      if (const auto order = effect.numbers.find("order"); order != effect.numbers.end())
        u.order = order->second;
      u.next = t.term.next;
      d.unexplained.push_back(std::move(u));
      continue;
    }
    const Eigen::MatrixXd covariance =
        variance_inflation(m, i) *
        m.solution().covariance.block(m.position(i), m.position(i), t.size(), t.size());
    Cause cause{effect, parameters(t.term, c, covariance), s.p_values[i], d.gain};
    causes.emplace_back(m.trial({i}, {}).residual.squaredNorm(), std::move(cause));
    for (const TipAlternative& a : s.alternatives)
      if (a.term == i)
        add_alternative(d, {effect.type, a.other.term.effect.type, a.other.term.effect.joint, record(a, t)});
  }
  std::stable_sort(causes.begin(), causes.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  for (auto& [removed, cause] : causes) d.causes.push_back(std::move(cause));
}

/// rms of what was tracked minus the model's tip [m].
double rms_without_causes(const OperationalModel& model, const TipEvidence& e) {
  double squares = 0;
  for (Eigen::Index k = 0; k < e.rows(); ++k) {
    const Eigen::Vector3d tip = tracked_tip(model.chain, e.joints.col(k)).translation();
    squares += (e.tip.col(k) - tip(e.axes)).squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(e.tip.size()));
}

/// A nuisance of the fit as a cause, with its value at the estimate. Of a value that is no more than its
/// uncertainty there is none.
/// @param first  of its columns among those of the nuisances
/// @param alone  whether nothing else explains or remains
void add_frame_cause(const TipModel& m, const std::string& type, const Eigen::VectorXd& value,
                     Eigen::Index first, bool alone, TipDiagnosis& d) {
  // What moves the tip by less is the frame's share of other errors, and raises what remains by less than a
  // tenth.
  constexpr double significant = 1e-4, unnoticed = 0.45;
  const Eigen::Index n = value.size();
  const Eigen::MatrixXd columns = m.all_columns().middleCols(first, n);
  const double inflation =
      std::max(TipModel::variance_inflation(m.solution(), columns,
                                            static_cast<Eigen::Index>(m.evidence().axes.size())),
               m.quantization_inflation(columns));
  const Eigen::MatrixXd covariance = inflation * m.solution().covariance.block(first, first, n, n);
  const NormalInverse information(covariance);
  const double p = chi_squared_tail(value.dot(information.inverse * value),
                                    static_cast<double>(std::max<Eigen::Index>(1, information.rank)));
  if (!(p < significant) || (!alone && signal_to_noise(m.solution(), columns, value) < unnoticed)) return;
  Cause cause{{type, "tip", {}, {}}, {}, p, d.gain};
  const std::vector<Parameter>& rows = effect_kind(type).parameters;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (columns.col(i).isZero(0)) continue;  // along a coordinate that is not logged
    const std::string name(rows[static_cast<std::size_t>(i)].name);
    const double half = 1.96 * std::sqrt(std::max(0.0, covariance(i, i)));
    cause.effect.numbers[name] = value[i];
    cause.parameters.push_back({name, value[i], value[i] - half, value[i] + half});
  }
  d.causes.push_back(std::move(cause));
}

/// @param alone  whether nothing else explains or remains
void name_frames(const TipModel& m, bool alone, TipDiagnosis& d) {
  const Eigen::Isometry3d base = m.estimate().base * m.nominal().tracker.inverse();
  const Eigen::Index of_base = m.frames().base ? 6 : 0;
  if (of_base > 0) {
    const Eigen::AngleAxisd turn(base.linear());
    Eigen::VectorXd motion(of_base);
    motion << base.translation(), turn.angle() * turn.axis();
    add_frame_cause(m, "frame", motion, 0, alone, d);
  }
  if (m.frames().target) add_frame_cause(m, "tool", m.estimate().tool, of_base, alone, d);
}

/// A displaced tool and a joint that is displaced, or turned, do the same in some records: on the last joints
/// of an arm in any.
void hedge_tool(const TipModel& m, TipDiagnosis& d) {
  constexpr double alike = 12;  // chi-squared of what tells them apart
  constexpr std::string_view record =
      "no pose of this record tells them apart: measure the tool, or move the last joints further";
  const Eigen::VectorXd root = m.solution().weight.cwiseSqrt();
  const auto told_apart = [&](const Eigen::VectorXd& displacement, const Eigen::MatrixXd& columns) {
    const Eigen::MatrixXd weighted = root.asDiagonal() * columns;
    const Eigen::VectorXd target = root.cwiseProduct(displacement);
    return (target - weighted * least_norm_solution(weighted, target)).squaredNorm() > alike;
  };
  const Eigen::MatrixXd tool = m.columns({TipTerm::Kind::tool, {}, 0});
  const auto add = [&](const std::string& cause, const std::string& other, const std::string& joint) {
    add_alternative(d, {cause, other, joint, std::string(record)});
  };
  if (!m.frames().target) {
    for (std::size_t i = 0; i < m.terms().size(); ++i)
      if (const TipTerm& t = m.terms()[i];
          t.kinematic() && t.term.named() && !told_apart(m.columns(i) * m.coefficients(i), tool))
        add(t.term.effect.type, "tool", "tip");
    return;
  }
  const Eigen::VectorXd displacement = tool * m.estimate().tool;
  if (std::none_of(d.causes.begin(), d.causes.end(), [](const Cause& c) { return c.effect.type == "tool"; }))
    return;
  for (const TipTerm& t : tip_terms(m.evidence(), m.estimate()))
    if (t.kinematic() && t.term.named() && !chosen(m, t) && !told_apart(displacement, m.columns(t)))
      add("tool", t.term.effect.type, t.term.effect.joint);
}

/// By how much the logged coordinates of the tip change per unit of each joint, at most [m/rad or 1], in
/// some rows of the record.
Eigen::MatrixXd sensitivity(const OperationalModel& model, const TipEvidence& e) {
  constexpr Eigen::Index enough_rows = 200;
  Eigen::MatrixXd largest = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(e.axes.size()), e.joints.rows());
  const Eigen::Index stride = std::max<Eigen::Index>(1, e.rows() / enough_rows);
  for (Eigen::Index k = 0; k < e.rows(); k += stride)
    largest = largest.cwiseMax(jacobian(model.chain, e.joints.col(k))(e.axes, Eigen::all).cwiseAbs());
  return largest;
}

/// Whether the joints move some logged coordinate by more than a count of each of them does.
bool moves(const OperationalModel& model, const TipEvidence& e, const Eigen::MatrixXd& sensitivity) {
  const Transmission& t = model.transmission;
  const Eigen::VectorXd steps = t.coupling.dense().cwiseAbs() * resolutions(t);
  Eigen::MatrixXd tip(sensitivity.rows(), e.rows());
  for (Eigen::Index k = 0; k < e.rows(); ++k)
    tip.col(k) = tracked_tip(model.chain, e.joints.col(k)).translation()(e.axes);
  const Eigen::VectorXd travel = tip.rowwise().maxCoeff() - tip.rowwise().minCoeff();
  return ((travel - sensitivity * steps).array() > 0).any();
}

std::string logged_coordinates(const TipEvidence& e) {
  std::string names;
  for (const Eigen::Index axis : e.axes)
    names += (names.empty() ? "tip." : ", tip.") + std::string(1, "xyz"[axis]);
  return names;
}

/// What the record does not show: joints that do not move the logged coordinates, or all of them.
void find_unseen(const OperationalModel& model, const TipEvidence& e, TipDiagnosis& d) {
  constexpr double negligible = 1e-9;  // rounding errors of the kinematics, in parts of the arm's reach
  constexpr double on_axis = 1e-12;    // [m]
  const Eigen::MatrixXd m_per_unit = sensitivity(model, e);
  const double least = negligible * m_per_unit.maxCoeff();
  for (Eigen::Index j = 0; j < m_per_unit.cols(); ++j)
    if (!e.to_joints.row(j).isZero() && m_per_unit.col(j).maxCoeff() <= least)
      d.unseen.push_back(model.chain.independent[static_cast<std::size_t>(j)].name);
  if (!d.causes.empty() || !d.unexplained.empty() || moves(model, e, m_per_unit)) return;
  d.judged = false;
  // On the axis of the only joint a tip rests, in the log as in the model: nothing was to be seen.
  const bool rests = (e.tip.colwise() - e.tip.col(0)).cwiseAbs().maxCoeff() <= e.log_resolution;
  if (rests && m_per_unit.maxCoeff() <= on_axis && d.unseen.empty()) {
    d.check = {};
    return;
  }
  d.reason = "the joints do not move '" + model.chain.tip + "' along " + logged_coordinates(e) +
             ": record coordinates that the joints move, through many counts of each, or 'JOINT.reference' "
             "with a reference sensor; or name another robot.tip";
}

/// Rows whose remainder no noise has: more than twelve times the median one, at most three of them or a
/// fifteenth of all rows, and where rows follow each other no more than three of them in a row.
std::vector<Eigen::Index> far_off(const TipEvidence& e, const Eigen::ArrayXd& distance) {
  constexpr double factor = 12, floor = 2;  // of the median, and of the log's rounding
  const double limit =
      std::max(factor * median({distance.begin(), distance.end()}), floor * e.log_resolution);
  std::vector<Eigen::Index> rows;
  Eigen::Index longest = 0, run = 0;
  // At the ends of a motion what lies beyond them is missing: the path, and what is late.
  const Eigen::Index end = e.ordered ? std::min<Eigen::Index>(5, distance.size() / 10) : 0;
  for (Eigen::Index k = end; k < distance.size() - end; ++k) {
    run = distance[k] > limit ? run + 1 : 0;
    longest = std::max(longest, run);
    if (run > 0) rows.push_back(k);
  }
  const bool few = static_cast<Eigen::Index>(rows.size()) <= std::max<Eigen::Index>(distance.size() / 15, 3);
  return few && !(e.ordered && longest > 3) ? rows : std::vector<Eigen::Index>{};
}

DataFinding outliers(const TipEvidence& e, const Log& log, const std::vector<Eigen::Index>& rows,
                     double largest) {
  std::vector<std::uint64_t> numbers;
  for (const Eigen::Index k : rows)
    numbers.push_back(log.row_number(e.row_of_log[static_cast<std::size_t>(k)]) + 1);
  return sanity::far_positions(
      numbers, largest, e.ordered ? std::optional(e.encoders.front().time[rows.front()]) : std::nullopt);
}

/// Selects the causes without positions that are far off. Each round leaves out fewer rows than are left.
/// @param e  receives the rows that are kept
std::unique_ptr<TipSelection> selected(const OperationalModel& model, std::unique_ptr<TipEvidence>& e,
                                       const Log& log, std::uint64_t seed, TipDiagnosis& d) {
  auto s = std::make_unique<TipSelection>(select_tip(model, *e, seed));
  constexpr int most_rounds = 3;
  for (int round = 0; round < most_rounds; ++round) {
    const Eigen::ArrayXd distance = s->model.in_base(s->model.solution().residual).rowwise().norm().array();
    const std::vector<Eigen::Index> far = far_off(*e, distance);
    if (far.empty()) break;
    d.data.push_back(outliers(*e, log, far, distance(far).maxCoeff()));
    std::vector<Eigen::Index> kept;
    for (Eigen::Index k = 0; k < e->rows(); ++k)
      if (!std::binary_search(far.begin(), far.end(), k)) kept.push_back(k);
    e = std::make_unique<TipEvidence>(with_rows(std::move(*e), kept));
    s = std::make_unique<TipSelection>(select_tip(model, *e, seed));
  }
  return s;
}

/// What no repeated reading of a pose has: a scatter from pose to pose beyond theirs, unless its shape is
/// known already. The floor of the remainder is then theirs, too.
void judge_by_repeats(const TipModel& m, TipDiagnosis& d) {
  const TipEvidence& e = m.evidence();
  if (e.repeat_noise == 0) return;
  constexpr double more = 2;  // convention: repeats do not show all of a tracker's noise
  const double noise = std::hypot(e.repeat_noise, e.log_resolution / std::sqrt(12.0)),
               sigma = m.solution().sigma;
  d.gain.sigma_ratio = d.gain.rms_after / std::sqrt(noise * noise + m.quantization());
  if (sigma < more * noise || !d.unexplained.empty()) return;
  d.unexplained.push_back(
      {"tip", "poses scatter more than their repeated readings", {}, {}, std::sqrt(2.0) * sigma});
  d.unexplained.back().next =
      "return to one pose several times during the record: what differs there is not the arm's geometry";
}

}  // namespace

TipDiagnosis diagnose_tip(const OperationalModel& ideal, const std::vector<Effect>& present, const Log& log,
                          std::uint64_t seed, unsigned threads) {
  TipDiagnosis d;
  OperationalModel model = ideal;
  model.chain = as_built(ideal.chain, present);
  std::optional<TipEvidence> recorded = tip_evidence(model, present, log, threads);
  if (!recorded) return d;
  d.judged = true;
  auto e = std::make_unique<TipEvidence>(std::move(*recorded));
  const auto selection = selected(model, e, log, seed, d);
  const TipSelection& s = *selection;
  const double without = rms_without_causes(model, *e);
  const TipModel bare(model, *e, {}, seed), alone = without_causes(s.model, bare);
  d.gain = gain_of(s.model, bare);
  const Eigen::MatrixXd simulated = simulated_tip(model, s.model),
                        residual = left_by_simulation(s.model, simulated);
  std::vector<Unidentified> left = tip_remainder(s.model, s.model.in_base(s.model.solution().residual));
  const bool absurd = cancel(s.model, without);
  if (!improves(s.model, alone) || absurd || (!left.empty() && outweighs(left.front(), d.gain))) {
    d.gain = gain_of(bare, bare);
    d.unexplained = tip_remainder(alone, alone.in_base(alone.solution().residual));
    for (std::size_t i = 0; i < alone.terms().size(); ++i) d.unexplained.push_back(tracker_finding(alone, i));
    if (absurd && d.unexplained.empty())
      d.unexplained.push_back(
          {"tip", "only errors that cancel bring the model near the tip", {}, {}, without});
    judge_by_repeats(alone, d);
    find_unseen(model, *e, d);
    return d;
  }
  // The fit linearizes: far from every arm of the catalogue it may leave more than it began with.
  if (!(d.gain.rms_after <= 2 * without + computed_tip)) {
    d.gain = {};
    d.unexplained.push_back(
        {"tip", "no error of the catalogue brings the model near the tip", {}, {}, without});
    return d;
  }
  d.check = reproduction(model, s.model, simulated, residual, without, d.gain);
  name_frames(s.model, s.model.terms().empty() && left.empty(), d);
  name_causes(s, d);
  for (Unidentified& u : left)
    if (!is_linearization(u, d.gain)) d.unexplained.push_back(std::move(u));
  judge_by_repeats(s.model, d);
  const std::string& first = model.chain.joints.front().name;
  const auto at_base = std::find_if(d.causes.begin(), d.causes.end(), [&](const Cause& c) {
    return effect_kind(c.effect.type).stage == Stage::kinematics && c.effect.joint == first;
  });
  if (at_base != d.causes.end() && !s.model.frames().base)
    d.alternatives.push_back(
        {at_base->effect.type, "frame", "tip",
         "no pose tells a displaced " + first + " from a displaced frame: survey the tracker at the base"});
  hedge_tool(s.model, d);
  find_unseen(model, *e, d);
  return d;
}

}  // namespace qerr
