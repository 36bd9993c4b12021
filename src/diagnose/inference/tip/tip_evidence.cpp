#include "diagnose/inference/tip/tip_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/parallel.hpp"
#include "diagnose/record/smooth_path.hpp"
#include "diagnose/record/with_effects.hpp"
#include "diagnose/search/unnamed_terms.hpp"
#include "effect/effects/effects.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index most_rows = 4000;

/// Time from the first row [s]; the row's number if the record has no time.
Eigen::ArrayXd time_of(const Log& log) {
  const Eigen::Index rows = log.values.rows();
  if (const auto stamps = log.find(LogSignal::time)) return log.values.col(*stamps) - log.values(0, *stamps);
  return Eigen::ArrayXd::LinSpaced(rows, 0, static_cast<double>(std::max<Eigen::Index>(rows - 1, 1)));
}

/// Path, velocity and direction of an encoder, from its own readings.
Evidence own_evidence(const OperationalModel& model, const Log& log, std::size_t i,
                      const Eigen::ArrayXd& measured, const Eigen::ArrayXd& time) {
  Evidence e;
  e.joint = model.chain.independent[i].name;
  e.prismatic = model.chain.independent[i].prismatic();
  e.encoder = model.transmission.encoders[i];
  e.ordered = log.has_time();
  e.time = time;
  e.reference = e.measured = e.path = measured;
  e.velocity = e.direction = Eigen::ArrayXd::Zero(measured.size());
  e.noise = sigma(e.encoder);
  if (e.ordered) {
    const SmoothPath smooth = smooth_path(time, measured, e.step(), true);
    e.path = smooth.position;
    e.velocity = smooth.velocity;
    e.direction = direction_of_motion(measured, 1.5 * e.step());
  }
  if (const auto effort = log.find(LogSignal::effort, i)) {
    e.effort = log.values.col(*effort);
    e.driven = !log.columns[static_cast<std::size_t>(*effort)].computed;
  }
  if (const auto warm = log.find(LogSignal::temperature, i))
    e.temperature = log.values.col(*warm) - log.values(0, *warm);
  return e;
}

/// The readings at the instants of their joints: at t the one whose clock says t.
Eigen::ArrayXd in_time(const Evidence& own, const std::vector<Effect>& of_clock) {
  Eigen::ArrayXd path = own.path;
  for (const Effect& effect : of_clock) {
    if (effect.joint != own.joint) continue;
    const Action instant = effect_kind(effect.type).action(effect, own.encoder, 0);
    const Eigen::ArrayXd read = path;
    for (Eigen::Index k = 0; k < own.rows(); ++k)
      path[k] = position_at(own.time, read, own.velocity,
                            2 * own.time[k] - instant(own.time[k], Moment{.time = own.time[k]}));
  }
  return path;
}

/// Moves the joints to where a model that has these effects expects them: path + what the effects add to it
/// is the reading. The path is a fixed point, as effects add little.
void take_off(TipEvidence& e, const std::vector<Effect>& present) {
  constexpr int most_rounds = 12;
  constexpr double negligible = 0.01;  // [counts]
  std::vector<Effect> of_clock, others;
  for (const Effect& effect : present) {
    const EffectKind& kind = effect_kind(effect.type);
    if (kind.stage != Stage::clock)
      others.push_back(effect);
    else if (e.ordered && !kind.random())
      of_clock.push_back(effect);
  }
  for (std::size_t i = 0; i < e.encoders.size(); ++i) {
    if (!e.judged(i)) continue;
    Evidence& own = e.encoders[i];
    const Eigen::ArrayXd read = own.path, timed = own.path = in_time(own, of_clock);
    Eigen::ArrayXd added = Eigen::ArrayXd::Zero(own.rows());
    for (int round = 0; round < most_rounds && !others.empty(); ++round) {
      const Eigen::ArrayXd before = added;
      added = with_effects(own, others).reference - own.reference;
      own.path = timed - added;
      if (!((added - before).abs().maxCoeff() > negligible * own.step())) break;
    }
    e.joints -= e.to_joints.col(static_cast<Eigen::Index>(i)) * (read - own.path).matrix().transpose();
  }
}

/// First rows of groups within which neither a joint nor the tip moves measurably.
std::vector<Eigen::Index> groups(const TipEvidence& e) {
  std::vector<Eigen::Index> starts{0};
  const double apart = 4 * std::max(e.noise, e.log_resolution);
  for (Eigen::Index k = 1; k < e.rows(); ++k) {
    const Eigen::Index first = starts.back();
    bool moved = !e.ordered || (e.tip.col(k) - e.tip.col(first)).cwiseAbs().maxCoeff() > apart;
    for (const Evidence& encoder : e.encoders)
      moved |= std::abs(encoder.measured[k] - encoder.measured[first]) > 0.05 * encoder.step() ||
               encoder.direction[k] != encoder.direction[first];
    if (moved) starts.push_back(k);
  }
  return starts;
}

/// Means over the groups, of every `stride`-th group.
class Fewer {
 public:
  Fewer(std::vector<Eigen::Index> starts, Eigen::Index rows, Eigen::Index stride)
      : starts_(std::move(starts)), rows_(rows), stride_(stride) {}

  Eigen::MatrixXd columns(const Eigen::MatrixXd& all) const {
    const auto groups = static_cast<Eigen::Index>(starts_.size());
    Eigen::MatrixXd out(all.rows(), (groups + stride_ - 1) / stride_);
    for (Eigen::Index g = 0; g < groups; g += stride_) {
      const Eigen::Index first = starts_[static_cast<std::size_t>(g)];
      const Eigen::Index end = g + 1 < groups ? starts_[static_cast<std::size_t>(g + 1)] : rows_;
      out.col(g / stride_) = all.middleCols(first, end - first).rowwise().mean();
    }
    return out;
  }
  void shorten(Eigen::ArrayXd& series) const {
    if (series.size() == 0) return;
    series = columns(series.matrix().transpose()).transpose().array().eval();
  }

 private:
  std::vector<Eigen::Index> starts_;
  Eigen::Index rows_, stride_;
};

/// @param starts  of the groups
double noise_of_means(const Eigen::MatrixXd& tip, const std::vector<Eigen::Index>& starts) {
  constexpr Eigen::Index fewest = 3;  // rows of a pose that is repeated
  constexpr std::size_t enough = 8;   // poses
  double squares = 0, free = 0, of_means = 0;
  std::size_t repeated = 0;
  for (std::size_t g = 0; g < starts.size(); ++g) {
    const Eigen::Index size = (g + 1 < starts.size() ? starts[g + 1] : tip.cols()) - starts[g];
    if (size < fewest) continue;
    const auto rows = tip.middleCols(starts[g], size);
    squares += (rows.colwise() - rows.rowwise().mean()).squaredNorm();
    free += static_cast<double>((size - 1) * tip.rows());
    of_means += 1 / static_cast<double>(size);
    ++repeated;
  }
  if (repeated < enough || 2 * repeated < starts.size()) return 0;
  return std::sqrt(squares / free * of_means / static_cast<double>(repeated));
}

void shorten(TipEvidence& e) {
  std::vector<Eigen::Index> starts = groups(e);
  e.repeat_noise = e.ordered ? noise_of_means(e.tip, starts) : 0;
  const Eigen::Index stride = (static_cast<Eigen::Index>(starts.size()) + most_rows - 1) / most_rows;
  for (std::vector<Eigen::Index>* numbers : {&e.row_of_log, &e.row_of_path}) {
    if (numbers->empty()) continue;
    std::vector<Eigen::Index> kept;
    for (std::size_t g = 0; g < starts.size(); g += static_cast<std::size_t>(stride))
      kept.push_back((*numbers)[static_cast<std::size_t>(starts[g])]);
    *numbers = std::move(kept);
  }
  const Fewer fewer(std::move(starts), e.rows(), stride);
  for (Evidence& encoder : e.encoders)
    for (Eigen::ArrayXd* series : series_of(encoder)) fewer.shorten(*series);
  e.joints = fewer.columns(e.joints);
  e.tip = fewer.columns(e.tip);
}

std::vector<Eigen::Index> counting(Eigen::Index rows) {
  std::vector<Eigen::Index> numbers(static_cast<std::size_t>(rows));
  std::iota(numbers.begin(), numbers.end(), Eigen::Index{0});
  return numbers;
}

/// Keeps the paths of all rows.
void keep_paths(TipEvidence& e) {
  auto paths = std::make_shared<std::vector<ReadPath>>();
  for (const Evidence& own : e.encoders) paths->push_back({own.time, own.measured, own.path, own.velocity});
  e.paths = std::move(paths);
  e.row_of_path = counting(e.rows());
}

/// Takes off the rows at both ends, whose neighbours in time are missing.
TipEvidence without_ends(TipEvidence e) {
  constexpr double longest = 0.2, part = 0.02;  // [s], and of the record
  if (!e.ordered || e.rows() == 0) return e;
  const Eigen::ArrayXd& time = e.encoders.front().time;
  const double first = time[0], last = time[e.rows() - 1], margin = std::min(longest, part * (last - first));
  std::vector<Eigen::Index> kept;
  for (Eigen::Index k = 0; k < e.rows(); ++k)
    if (time[k] >= first + margin && time[k] <= last - margin) kept.push_back(k);
  return with_rows(std::move(e), kept);
}

}  // namespace

std::optional<TipEvidence> tip_evidence(const OperationalModel& model, const std::vector<Effect>& present,
                                        const Log& log, unsigned threads) {
  TipEvidence e;
  std::vector<Eigen::Index> columns;
  for (std::size_t i = 0; i < 3; ++i)
    if (const auto column = log.find(LogSignal::tip, i)) {
      e.axes.push_back(static_cast<Eigen::Index>(i));
      columns.push_back(*column);
      e.log_resolution = std::max(e.log_resolution, resolution_of(log, *column));
    }
  const auto count = static_cast<Eigen::Index>(model.chain.independent.size());
  const Eigen::Index rows = log.values.rows();
  if (columns.empty() || rows < 8) return std::nullopt;
  e.ordered = log.has_time();
  const Eigen::ArrayXd time = time_of(log);
  e.tip = log.values(Eigen::all, columns).matrix().transpose();
  e.joints.resize(count, rows);
  e.joint_noise.setZero(count);
  e.to_joints = model.transmission.coupling.dense();
  Eigen::MatrixXd read(count, rows);
  for (Eigen::Index j = 0; j < count; ++j) {
    const auto joint = static_cast<std::size_t>(j);
    const auto measured = measured_joint(log, log.values, model.transmission, joint);
    const auto reference = log.find(LogSignal::reference, joint);
    if (!measured && !reference) return std::nullopt;
    if (reference) {
      const double grid = resolution_of(log, *reference);
      e.joints.row(j) = log.values.col(*reference).matrix().transpose();
      e.joint_noise[j] =
          e.ordered ? noise_of_path(time, log.values.col(*reference), grid) : grid / std::sqrt(12.0);
      e.to_joints.row(j).setZero();
    } else {
      e.joints.row(j) = measured->matrix().transpose();
    }
    read.row(j) = e.joints.row(j);
  }
  e.delayed = e.to_joints;
  for (Eigen::Index i = 0; i < count; ++i)
    if (!e.judged(static_cast<std::size_t>(i))) e.delayed.col(i) = model.transmission.coupling.dense().col(i);
  const Eigen::MatrixXd turned = model.transmission.coupling.inverse() * read;
  e.encoders.resize(static_cast<std::size_t>(count));
  parallel_for(e.encoders.size(), threads, [&](std::size_t i) {
    e.encoders[i] = own_evidence(model, log, i, turned.row(static_cast<Eigen::Index>(i)).array(), time);
  });
  take_off(e, present);
  e.row_of_log = counting(rows);
  // Between the samples of a slower tracker its noise is alike from row to row.
  const std::vector<Eigen::Index> fresh = log.rows_at_samples(static_cast<std::size_t>(columns.front()));
  if (!fresh.empty()) {
    keep_paths(e);
    e = with_rows(std::move(e), fresh);
  }
  const double first = e.ordered ? log.values(0, *log.find(LogSignal::time)) : 0;
  for (Eigen::Index axis = 0; axis < e.tip.rows() && e.ordered; ++axis) {
    const Eigen::ArrayXd& stamps = e.encoders.front().time;
    const LogColumn& head = log.columns[static_cast<std::size_t>(columns[static_cast<std::size_t>(axis)])];
    e.noise = std::max({e.noise, noise_of_path(stamps, e.tip.row(axis).transpose(), e.log_resolution),
                        noise_between(head, stamps + first)});
  }
  shorten(e);
  if (fresh.empty()) keep_paths(e);
  return without_ends(std::move(e));
}

TipEvidence with_rows(TipEvidence e, const std::vector<Eigen::Index>& rows) {
  for (Evidence& encoder : e.encoders)
    for (Eigen::ArrayXd* series : series_of(encoder))
      if (series->size() > 0) *series = (*series)(rows).eval();
  e.joints = e.joints(Eigen::all, rows).eval();
  e.tip = e.tip(Eigen::all, rows).eval();
  for (std::vector<Eigen::Index>* numbers : {&e.row_of_log, &e.row_of_path}) {
    if (numbers->empty()) continue;
    std::vector<Eigen::Index> kept;
    for (const Eigen::Index k : rows) kept.push_back((*numbers)[static_cast<std::size_t>(k)]);
    *numbers = std::move(kept);
  }
  return e;
}

TipPose TipEstimate::pose(const TipEvidence& e, Eigen::Index row) const {
  const auto count = static_cast<Eigen::Index>(chain.joints.size());
  const Eigen::VectorXd q = e.joints.col(row) - e.delayed * additions.col(row);
  TipPose p{Eigen::Matrix3Xd(3, count), Eigen::Matrix3Xd(3, count), {}, {}, {}, {}, {}, {}};
  Eigen::Isometry3d frame = base;
  for (Eigen::Index j = 0; j < count; ++j) {
    const ChainJoint& joint = chain.joints[static_cast<std::size_t>(j)];
    const double motion = joint.multiplier * q[static_cast<Eigen::Index>(joint.coordinate)] + joint.offset;
    p.motion.push_back(motion);
    p.before.push_back(frame.linear());
    frame = frame * joint.origin;
    p.origin.col(j) = frame.translation();
    p.axis.col(j) = frame.linear() * joint.axis;
    if (joint.prismatic)
      frame.translate(motion * joint.axis);
    else
      frame.rotate(Eigen::AngleAxisd(motion, joint.axis));
  }
  p.before.push_back(frame.linear());
  frame = frame * chain.tip_offset;
  p.tool = frame.linear();
  p.tip = frame * tool;
  Eigen::MatrixXd columns(3, count);
  for (Eigen::Index j = 0; j < count; ++j) {
    const Eigen::Vector3d axis = p.axis.col(j), arm = p.tip - p.origin.col(j);
    columns.col(j) = chain.joints[static_cast<std::size_t>(j)].prismatic ? axis : axis.cross(arm);
  }
  p.joints = to_independent(chain, columns);
  p.encoders = p.joints * e.to_joints;
  return p;
}

Eigen::Index TipTerm::size() const {
  switch (kind) {
    case Kind::encoder:
      return term.size();
    case Kind::late:
      return 1;
    case Kind::geometry:
    case Kind::frame_tilt:
    case Kind::axis_tilt:
      return directions.cols();
    case Kind::base:
      return 6;
    case Kind::tool:
      return 3;
    case Kind::tracker:
    case Kind::target:
    case Kind::growth:
      return term.size() * directions.cols();
  }
  return 0;
}

namespace {

double read_at(const TipEvidence& e, std::size_t encoder, double instant) {
  const ReadPath& path = (*e.paths)[encoder];
  return position_at(path.time, path.position, path.velocity, instant);
}

}  // namespace

double added_by_delay(const TipEvidence& e, std::size_t encoder, Eigen::Index row, double delay) {
  // The reading is of `delay` before; where the joint is now will be read then.
  const double time = e.encoders[encoder].time[row];
  return read_at(e, encoder, time) - read_at(e, encoder, time + delay);
}

Eigen::MatrixXd slopes_by_delay(const TipEvidence& e, const Eigen::MatrixXd& delay) {
  constexpr double h = 1e-3;  // [s], within which rates hardly change
  if (!e.ordered) return {};
  Eigen::MatrixXd slopes(delay.rows(), delay.cols());
  for (Eigen::Index i = 0; i < slopes.rows(); ++i)
    for (Eigen::Index k = 0; k < slopes.cols(); ++k) {
      const auto encoder = static_cast<std::size_t>(i);
      const double then = e.encoders[encoder].time[k] + delay(i, k);
      slopes(i, k) = (read_at(e, encoder, then - h) - read_at(e, encoder, then + h)) / (2 * h);
    }
  return slopes;
}

TipColumns TipTerm::at(const TipPose& p, const TipEvidence& e, const TipEstimate& estimate,
                       Eigen::Index row) const {
  const auto place = static_cast<Eigen::Index>(where);
  TipColumns columns(3, size());
  switch (kind) {
    case Kind::encoder:
      columns = p.encoders.col(place) * term.columns.row(row).matrix();
      break;
    case Kind::late:
      columns.setZero();
      for (std::size_t i = 0; i < e.encoders.size(); ++i)
        if (delays(i, e)) {
          const auto at = static_cast<Eigen::Index>(i);
          columns += p.joints * e.delayed.col(at) * (estimate.slope(at, row) * term.columns(row, 0));
        }
      break;
    case Kind::geometry:
      // The true joint is displaced from the model's: estimate - true is minus the displacement.
      columns = -p.before[where] * directions;
      break;
    case Kind::frame_tilt:
    case Kind::axis_tilt: {
      const Eigen::Vector3d axis = p.axis.col(place), arm = p.tip - p.origin.col(place);
      const auto displaced = [&](const Eigen::Vector3d& about) -> Eigen::Vector3d {
        if (kind == Kind::frame_tilt) return about.cross(arm);
        if (slides) return p.motion[where] * about.cross(axis);
        // There and, after the joint, back: R(a + da, q) = T R(a, q) T^-1.
        return (about - Eigen::AngleAxisd(p.motion[where], axis) * about).cross(arm);
      };
      for (Eigen::Index i = 0; i < columns.cols(); ++i)
        columns.col(i) = -displaced(p.before[where] * directions.col(i));
      break;
    }
    case Kind::base:
      columns.leftCols<3>() = -Eigen::Matrix3d::Identity();
      for (Eigen::Index i = 0; i < 3; ++i) columns.col(3 + i) = -Eigen::Vector3d::Unit(i).cross(p.tip);
      break;
    case Kind::tool:
      columns = -p.tool;
      break;
    case Kind::tracker:
    case Kind::target:
    case Kind::growth:
      for (Eigen::Index i = 0; i < term.size(); ++i) {
        auto one = columns.middleCols(i * directions.cols(), directions.cols());
        one = -term.columns(row, i) * directions;
        if (kind == Kind::target) one = (p.tool * one).eval();
        if (kind == Kind::growth) one = (p.before[where] * one).eval();
      }
      break;
  }
  return columns;
}

Evidence corrected_evidence(const TipEvidence& e, const TipEstimate& estimate, std::size_t encoder) {
  Evidence own = e.encoders[encoder];
  own.path -= estimate.additions.row(static_cast<Eigen::Index>(encoder)).transpose().array();
  return own;
}

namespace {

/// Path of a joint less what the causes add to its readings.
Eigen::ArrayXd corrected_joint(const TipEvidence& e, const TipEstimate& estimate, std::size_t joint) {
  const auto j = static_cast<Eigen::Index>(joint);
  return (e.joints.row(j) - e.delayed.row(j) * estimate.additions).transpose().array();
}

/// The term of an effect of the clock, with the delay that a unit of its parameter makes in each row.
Term delay_term(const Evidence& own, Term t) {
  Effect unit = t.effect;
  t.fill(unit, Eigen::VectorXd::Ones(1));
  const Action instant = effect_kind(unit.type).action(unit, own.encoder, 0);
  Eigen::ArrayXXd delay(own.rows(), 1);
  for (Eigen::Index k = 0; k < own.rows(); ++k)
    delay(k, 0) = own.time[k] - instant(own.time[k], Moment{.time = own.time[k]});
  return with_columns(std::move(t), std::move(delay));
}

/// Encoders that follow another joint, too.
std::vector<TipTerm> coupling_terms(const TipEvidence& e, const TipEstimate& estimate) {
  std::vector<TipTerm> terms;
  for (std::size_t other = 0; other < e.encoders.size(); ++other) {
    if (e.encoders[other].is_stationary()) continue;
    const Eigen::ArrayXd path = corrected_joint(e, estimate, other);
    for (std::size_t i = 0; i < e.encoders.size(); ++i)
      if (i != other && e.judged(i))
        terms.push_back(
            {TipTerm::Kind::encoder, coupling_term(e.encoders[i], e.encoders[other].joint, path), i});
  }
  return terms;
}

}  // namespace

std::vector<TipTerm> tip_terms(const TipEvidence& e, const TipEstimate& estimate) {
  std::vector<TipTerm> terms;
  const Chain& chain = estimate.chain;
  for (std::size_t j = 0; j < chain.joints.size(); ++j) {
    const std::string& name = chain.joints[j].name;
    if (std::none_of(chain.independent.begin(), chain.independent.end(),
                     [&](const IndependentJoint& i) { return i.name == name; }))
      continue;  // a mimic joint has no effects of its own
    for (const EffectKind& kind : effect_kinds())
      if (kind.displacements)
        for (Term& t : kind.displacements(name)) {
          const OriginPlace place = origin_place(chain, j);
          const Eigen::Vector3d direction = place.axes * displacement_direction(t.effect);
          terms.push_back({TipTerm::Kind::geometry, std::move(t), place.link, direction});
        }
  }
  const auto count = e.encoders.size();
  std::vector<Term> late;  // of the last encoder that moves
  bool any = false;
  for (std::size_t i = 0; i < count; ++i) {
    any = any || e.judged(i);
    std::vector<Term> of_clock;
    const Evidence own = corrected_evidence(e, estimate, i);
    for (Term& t : named_terms(own)) {
      if (t.shapes && !t.columns.any()) continue;  // the joint's path does not tell its parameter
      if (t.of_reference) t.hysteresis = nullptr;  // the joint's path, which drives it, is not known
      const bool delays = effect_kind(t.effect.type).stage == Stage::clock;
      if (delays) of_clock.push_back(t = delay_term(own, std::move(t)));
      if (e.judged(i))
        terms.push_back({delays ? TipTerm::Kind::late : TipTerm::Kind::encoder, std::move(t), i});
    }
    if (!of_clock.empty()) late = std::move(of_clock);
  }
  for (TipTerm& t : coupling_terms(e, estimate)) terms.push_back(std::move(t));
  for (Term& t : late) {
    if (count < 2 && any) break;  // it is that of the one encoder
    t.effect.joint = "tip";
    terms.push_back({TipTerm::Kind::late, std::move(t), count});
  }
  return terms;
}

std::vector<TipTerm> tilt_terms(const Chain& chain) {
  std::vector<TipTerm> terms;
  for (std::size_t j = 0; j < chain.joints.size(); ++j) {
    const ChainJoint& joint = chain.joints[j];
    const Eigen::Vector3d axis = joint.origin.linear() * joint.axis, across = axis.unitOrthogonal();
    for (const TipTerm::Kind kind : {TipTerm::Kind::frame_tilt, TipTerm::Kind::axis_tilt}) {
      if (kind == TipTerm::Kind::frame_tilt && (j == 0 || joint.prismatic)) continue;
      TipTerm t{kind, {}, j};
      t.directions.resize(3, 2);
      t.directions << across, axis.cross(across);
      t.slides = joint.prismatic;
      t.term.effect.joint = chain.independent[joint.coordinate].name;
      t.term.fill = [](Effect& x, const Eigen::VectorXd& c) { x.numbers["amplitude"] = c.norm(); };
      t.term.unnamed = "the axis of the joint is askew";
      t.term.next = kind == TipTerm::Kind::frame_tilt
                        ? "measure the axis, and correct the rpy of its joint's <origin> in the URDF"
                        : "measure the axis, and correct its joint's <axis> in the URDF";
      terms.push_back(std::move(t));
    }
  }
  return terms;
}

void tilt(ChainJoint& joint, TipTerm::Kind kind, const Eigen::Vector3d& rotation) {
  if (rotation.norm() == 0) return;
  const Eigen::AngleAxisd turn(rotation.norm(), rotation.normalized());
  const Eigen::Matrix3d frame = joint.origin.linear();
  if (kind == TipTerm::Kind::axis_tilt)
    joint.axis = frame.transpose() * (turn * (frame * joint.axis));
  else
    joint.origin.linear() = turn * frame;
}

void update_columns(TipTerm& t, const Eigen::VectorXd& c, const TipEvidence& e, const TipEstimate& estimate) {
  if (t.kind != TipTerm::Kind::encoder) return;
  const Evidence own = corrected_evidence(e, estimate, t.where);
  const Effect& effect = t.term.effect;
  if (effect.type == coupling_error_effect().name) {
    for (std::size_t i = 0; i < e.encoders.size(); ++i)
      if (e.encoders[i].joint == effect.choices.at("of")) t.term.columns = corrected_joint(e, estimate, i);
  } else if (t.term.hysteresis) {
    if (c[0] > own.step())
      t.term.columns = t.term.hysteresis((*e.paths)[t.where].measured, c[0])(e.row_of_path);
  } else if (t.term.step) {
    return;  // independent of the path
  } else if (t.term.reshaped) {
    t.term = t.term.reshaped(own, t.term, t.term.shape);
  } else {
    // Of the linearizations of one effect, one with as many coefficients.
    for (Term& fresh : effect_kind(effect.type).terms(own))
      if (fresh.size() == t.size() && fresh.effect.choices == effect.choices &&
          fresh.effect.number_or("order", 0) == effect.number_or("order", 0) &&
          fresh.effect.number_or("time_constant", 0) == effect.number_or("time_constant", 0))
        t.term.columns = std::move(fresh.columns);
  }
}

}  // namespace qerr
