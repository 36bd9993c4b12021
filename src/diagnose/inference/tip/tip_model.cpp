#include "diagnose/inference/tip/tip_model.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/random.hpp"
#include "core/solve.hpp"
#include "diagnose/inference/tip/tip_weight.hpp"
#include "diagnose/search/linear_model.hpp"
#include "simulate/sensing.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index most_tip_blocks = 64;
constexpr double negligible = 1e-5;

}  // namespace

TipModel::TipModel(const OperationalModel& model, const TipEvidence& evidence, UnknownFrames frames,
                   std::uint64_t seed)
    : model_(&model), evidence_(&evidence), frames_(frames), seed_(seed) {
  estimate_.chain = model.chain;
  estimate_.base = model.chain.tracker;
  estimate_.additions.setZero(static_cast<Eigen::Index>(evidence.encoders.size()), evidence.rows());
  estimate_.delay = estimate_.additions;
  theta_.resize(0);
  if (frames_.base) align();
  fit();
  draw_surrogates();
}

Eigen::MatrixXd TipModel::in_base(const Eigen::VectorXd& entries) const {
  const auto coordinates = static_cast<Eigen::Index>(evidence_->axes.size());
  Eigen::MatrixXd series(evidence_->rows(), coordinates);
  for (Eigen::Index k = 0; k < series.rows(); ++k) {
    const auto& turn = turn_[static_cast<std::size_t>(k)];
    series.row(k) =
        (turn(Eigen::all, evidence_->axes).transpose() * entries.segment(k * coordinates, coordinates))
            .transpose();
  }
  return series;
}

Eigen::Index TipModel::size() const { return theta_.size(); }

Eigen::Index TipModel::position(std::size_t term) const {
  Eigen::Index at = nuisance_.cols();
  for (std::size_t i = 0; i < term; ++i) at += terms_[i].size();
  return at;
}

Eigen::VectorXd TipModel::coefficients(std::size_t term) const {
  return theta_.segment(position(term) - nuisance_.cols(), terms_[term].size());
}

void TipModel::add(TipTerm term, const Eigen::VectorXd& coefficients) {
  theta_.conservativeResize(theta_.size() + coefficients.size());
  theta_.tail(coefficients.size()) = coefficients;
  term_columns_.push_back(columns(term));
  terms_.push_back(std::move(term));
}

void TipModel::remove(std::size_t term) {
  const Eigen::Index at = position(term) - nuisance_.cols(), gone = terms_[term].size();
  Eigen::VectorXd kept(theta_.size() - gone);
  kept << theta_.head(at), theta_.tail(theta_.size() - at - gone);
  theta_ = kept;
  terms_.erase(terms_.begin() + static_cast<std::ptrdiff_t>(term));
  term_columns_.erase(term_columns_.begin() + static_cast<std::ptrdiff_t>(term));
}

void TipModel::exchange(std::size_t term, TipTerm other, const Eigen::VectorXd& coefficients) {
  remove(term);
  add(std::move(other), coefficients);
}

Eigen::MatrixXd TipModel::read_columns(std::size_t encoder, const Eigen::ArrayXXd& addition) const {
  const auto coordinates = static_cast<Eigen::Index>(evidence_->axes.size());
  const auto read = read_.col(static_cast<Eigen::Index>(encoder));
  Eigen::MatrixXd out(read.size(), addition.cols());
  for (Eigen::Index i = 0; i < out.cols(); ++i)
    for (Eigen::Index k = 0; k < addition.rows(); ++k)
      for (Eigen::Index at = k * coordinates; at < (k + 1) * coordinates; ++at)
        out(at, i) = read[at] * addition(k, i);
  return out;
}

Eigen::MatrixXd TipModel::columns(const TipTerm& t) const {
  if (t.kind == TipTerm::Kind::encoder) return read_columns(t.where, t.term.columns);
  const auto coordinates = static_cast<Eigen::Index>(evidence_->axes.size());
  Eigen::MatrixXd out(y_.size(), t.size());
  for (Eigen::Index k = 0; k < evidence_->rows(); ++k) {
    const auto row = static_cast<std::size_t>(k);
    out.middleRows(k * coordinates, coordinates).noalias() =
        turn_[row] * t.at((*poses_)[row], *evidence_, estimate_, k);
  }
  return out;
}

Eigen::MatrixXd TipModel::all_columns(const std::vector<std::size_t>& without, Eigen::Index more) const {
  const auto used = [&](std::size_t i) {
    return std::find(without.begin(), without.end(), i) == without.end();
  };
  Eigen::Index count = nuisance_.cols() + more;
  for (std::size_t i = 0; i < terms_.size(); ++i)
    if (used(i)) count += terms_[i].size();
  Eigen::MatrixXd all(y_.size(), count);
  all.leftCols(nuisance_.cols()) = nuisance_;
  Eigen::Index at = nuisance_.cols();
  for (std::size_t i = 0; i < terms_.size(); ++i)
    if (used(i)) {
      all.middleCols(at, terms_[i].size()) = term_columns_[i];
      at += terms_[i].size();
    }
  return all;
}

TipSolution TipModel::trial(const std::vector<std::size_t>& without, const Eigen::MatrixXd& extra) const {
  Eigen::MatrixXd x = all_columns(without, extra.cols());
  if (extra.cols() > 0) x.rightCols(extra.cols()) = extra;
  const double least = std::max({0.5 * evidence_->noise, 0.3 * evidence_->log_resolution, 1e-9});
  return solve(x, y_, known_, least, solution_.sigma > 0 ? std::optional(solution_.sigma) : std::nullopt);
}

TipModel::Projection TipModel::projection(const std::vector<std::size_t>& without) const {
  Projection p{all_columns(without), {}, {}};
  p.weighted = solution_.weight.asDiagonal() * p.columns;
  NormalInverse normal(
      weighted_gram(p.columns, y_, solution_.weight).topLeftCorner(p.columns.cols(), p.columns.cols()));
  p.inverse = std::move(normal.inverse);
  p.rank = normal.rank;
  return p;
}

Eigen::MatrixXd TipModel::beyond_others(std::size_t term) const {
  const Projection& all = *projection_;
  const Eigen::Index at = position(term), size = terms_[term].size();
  if (all.rank < all.columns.cols()) return beyond(projection({term}), term_columns_[term]);
  // With C = (X^T W X)^-1, X C_:i is what its other columns leave of X_i, times C_ii.
  const Eigen::MatrixXd own = inverse(all.inverse.block(at, at, size, size));
  return all.columns * (all.inverse.middleCols(at, size) * own);
}

Eigen::MatrixXd TipModel::beyond(const Projection& p, const Eigen::MatrixXd& columns) const {
  if (p.columns.cols() == 0) return columns;
  Eigen::MatrixXd left = columns - p.columns * (p.inverse * (p.weighted.transpose() * columns));
  const Eigen::VectorXd root = solution_.weight.cwiseSqrt();
  for (Eigen::Index i = 0; i < left.cols(); ++i)
    if (root.cwiseProduct(left.col(i)).norm() < negligible * root.cwiseProduct(columns.col(i)).norm())
      left.col(i).setZero();
  return left;
}

double TipModel::gain(const Eigen::MatrixXd& columns) const {
  // Where other columns leave a smaller part of a column's square, the difference of squares has too few
  // digits.
  constexpr double plain = 1e-3;
  const Eigen::MatrixXd weighted = solution_.weight.asDiagonal() * columns;
  Eigen::MatrixXd information = columns.transpose() * weighted;
  Eigen::VectorXd score = weighted.transpose() * solution_.residual;
  const Eigen::VectorXd alone = information.diagonal();
  if (const Projection& p = *projection_; p.columns.cols() > 0) {
    const Eigen::MatrixXd shared = p.columns.transpose() * weighted, on = p.inverse * shared;
    information -= shared.transpose() * on;
    score -= on.transpose() * (p.weighted.transpose() * solution_.residual);
  }
  if ((information.diagonal().array() <= plain * alone.array()).any())
    return gain_of(solution_, beyond(columns));
  information.diagonal().array() *= 1 + 1e-10;
  return 0.5 * score.dot(solve_symmetric(information, score));
}

double TipModel::variance_inflation(const TipSolution& s, const Eigen::MatrixXd& columns,
                                    Eigen::Index coordinates) {
  const Eigen::VectorXd pull = s.weight.cwiseProduct(s.residual);
  const Eigen::Index rows = pull.size() / coordinates, blocks = std::min(most_tip_blocks, rows / 8);
  if (blocks < 4) return 1;
  const Eigen::MatrixXd scores = pull.asDiagonal() * columns;
  double within = 0, together = 0;
  for (Eigen::Index i = 0; i < scores.cols(); ++i) {
    for (Eigen::Index k = 0; k < rows; ++k)
      within += std::pow(scores.col(i).segment(k * coordinates, coordinates).sum(), 2);
    for (Eigen::Index b = 0; b < blocks; ++b) {
      const Eigen::Index first = b * rows / blocks, last = (b + 1) * rows / blocks;
      together += std::pow(scores.col(i).segment(first * coordinates, (last - first) * coordinates).sum(), 2);
    }
  }
  return std::max(1.0, together / std::max(within, 1e-300));
}

double TipModel::quantization_inflation(const Eigen::MatrixXd& beyond) const {
  if (surrogates_.cols() == 0) return 1;
  const Eigen::MatrixXd weighted = solution_.weight.asDiagonal() * beyond;
  const NormalInverse normal(beyond.transpose() * weighted);
  if (normal.rank == 0) return 1;
  const Eigen::MatrixXd scores = weighted.transpose() * surrogates_;
  const double explained = (scores.array() * (normal.inverse * scores).array()).sum() /
                           static_cast<double>(surrogates_.cols() * normal.rank);
  return explained + std::pow(solution_.sigma, 2) * solution_.weight.mean();
}

double TipModel::value(const TipSolution& s, Eigen::Index coefficients) const {
  return s.log_likelihood -
         0.5 * static_cast<double>(coefficients) * std::log(static_cast<double>(y_.size()));
}

/// How a model of the tip is fitted: estimate, linearization, solution, and again.

namespace {

constexpr Eigen::Index path_draws = 40;  // of quantization along the path

// The rigid motion T that minimizes sum |T from_k - to_k|^2. Its rotation is the quaternion that belongs to
// the largest eigenvalue of a symmetric 4x4 matrix of the correlations. Source: Horn, "Closed-form solution
// of absolute orientation using unit quaternions", J. Opt. Soc. Am. A 4 (1987).
Eigen::Isometry3d rigid_alignment(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to) {
  const Eigen::Vector3d centre_from = from.rowwise().mean(), centre_to = to.rowwise().mean();
  Eigen::Matrix3d s;  // correlations
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = 0; j < 3; ++j)
      s(i, j) = (from.row(i).array() - centre_from[i]).matrix().dot(to.row(j));
  const Eigen::Vector3d difference(s(1, 2) - s(2, 1), s(2, 0) - s(0, 2), s(0, 1) - s(1, 0));
  Eigen::MatrixXd n(4, 4);
  n(0, 0) = s.trace();
  n.topRightCorner(1, 3) = difference.transpose();
  n.bottomLeftCorner(3, 1) = difference;
  n.bottomRightCorner(3, 3) = s + s.transpose() - s.trace() * Eigen::Matrix3d::Identity();
  const Eigen::VectorXd q = symmetric_eigen(n).vectors.col(3);
  Eigen::Isometry3d moved(Eigen::Quaterniond(q[0], q[1], q[2], q[3]));
  moved.translation() = centre_to - moved.linear() * centre_from;
  return moved;
}

// Sub-count phases of a path that is known from the readings only [counts]. While a joint moves, the smooth
// path follows it within the counts, and one phase stands for all edges; a joint that rests is anywhere
// within its count, at each rest elsewhere. Between rests the phase goes from one to the next.
Eigen::ArrayXd drawn_phases(const Evidence& e, std::uint64_t seed, std::uint64_t draw) {
  const auto still = [&](Eigen::Index k) {  // from row k to the next: smoothing leaves what is constant
    return k >= 0 && k + 1 < e.rows() && std::abs(e.path[k + 1] - e.path[k]) < 1e-6 * e.step();
  };
  std::uint64_t rest = 0;
  double phase = unit_interval(random_bits(seed, rest, draw));
  Eigen::ArrayXd phases(e.rows());
  Eigen::Index moving = 0;  // the first row behind the last rest
  for (Eigen::Index k = 0; k < e.rows(); ++k) {
    if (!still(k - 1) && !still(k)) continue;
    if (!still(k - 1)) {
      const double next = unit_interval(random_bits(seed, ++rest, draw));
      for (Eigen::Index i = moving; i < k; ++i)
        phases[i] =
            std::lerp(phase, next, static_cast<double>(i + 1 - moving) / static_cast<double>(k + 1 - moving));
      phase = next;
    }
    phases[k] = phase;
    moving = k + 1;
  }
  phases.tail(e.rows() - moving) = phase;
  return phases;
}

}  // namespace

SecondOrder second_order(const TipPose& p, const Chain& chain, const Eigen::MatrixXd& to_joints,
                         const Eigen::VectorXd& steps) {
  const auto moving = static_cast<Eigen::Index>(chain.joints.size());
  // Motion of each moving joint per unit of each encoder.
  const Eigen::MatrixXd share = to_independent(chain, Eigen::MatrixXd::Identity(moving, moving)) * to_joints;
  const Eigen::Index encoders = share.cols();
  SecondOrder s{{}, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero()};
  s.hessian.assign(static_cast<std::size_t>(encoders), Eigen::Matrix3Xd::Zero(3, encoders));
  for (Eigen::Index near = 0; near < moving; ++near) {
    if (chain.joints[static_cast<std::size_t>(near)].prismatic) continue;
    for (Eigen::Index far = near; far < moving; ++far) {
      const Eigen::Vector3d axis = p.axis.col(far), arm = p.tip - p.origin.col(far);
      const bool slides = chain.joints[static_cast<std::size_t>(far)].prismatic;
      const Eigen::Vector3d speed = slides ? axis : axis.cross(arm);
      // A joint turns the speed that those beyond it give the tip.
      const Eigen::Vector3d turned = p.axis.col(near).cross(speed);
      std::vector<Eigen::Index> moved;
      for (Eigen::Index a = 0; a < encoders; ++a)
        if (share(near, a) != 0 || share(far, a) != 0) moved.push_back(a);
      for (const Eigen::Index a : moved)
        for (const Eigen::Index b : moved) {
          const double both =
              share(near, a) * share(far, b) + (far > near ? share(far, a) * share(near, b) : 0);
          s.hessian[static_cast<std::size_t>(a)].col(b) += both * turned;
        }
    }
  }
  // Of a uniform error: E delta^2 = Delta^2 / 12, Var delta^2 = Delta^4 / 180.
  for (Eigen::Index a = 0; a < encoders; ++a)
    for (Eigen::Index b = 0; b <= a; ++b) {
      const Eigen::Vector3d h = s.hessian[static_cast<std::size_t>(a)].col(b);
      const double product = std::pow(steps[a] * steps[b], 2);
      if (a == b) s.mean -= h * std::pow(steps[a], 2) / 24;
      s.covariance += h * h.transpose() * (a == b ? product / 720 : product / 144);
    }
  return s;
}

/// Rotation and translation from the model's tip to the tracked one, where they differ strongly: a start for
/// the fit, which is linearized in the rotation (Kabsch).
void TipModel::align() {
  if (evidence_->axes.size() < 3) return;
  Eigen::Matrix3Xd tip(3, evidence_->rows());
  for (Eigen::Index k = 0; k < evidence_->rows(); ++k) tip.col(k) = estimate_.pose(*evidence_, k).tip;
  const Eigen::Matrix3Xd tracked = evidence_->tip;
  const Eigen::Matrix3Xd centred = tracked.colwise() - tracked.rowwise().mean();
  if ((tip - tracked).norm() < 0.02 * centred.norm()) return;
  estimate_.base = rigid_alignment(tip, tracked) * estimate_.base;
}

/// Updates link dimensions, tilts of axes and encoder corrections by the coefficients.
void TipModel::update_estimate() {
  std::vector<Effect> built;
  const Eigen::MatrixXd before = estimate_.delay;
  estimate_.additions.setZero();
  estimate_.delay.setZero();
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    TipTerm& t = terms_[i];
    const Eigen::VectorXd c = coefficients(i);
    if (t.kind == TipTerm::Kind::geometry) {
      built.push_back(t.term.effect);
      t.term.fill(built.back(), c);
    } else if (t.kind == TipTerm::Kind::encoder) {
      estimate_.additions.row(static_cast<Eigen::Index>(t.where)) +=
          (t.term.columns.matrix() * c).transpose();
    } else if (t.kind == TipTerm::Kind::late) {
      for (std::size_t e = 0; e < evidence_->encoders.size(); ++e)
        if (t.delays(e, *evidence_))
          estimate_.delay.row(static_cast<Eigen::Index>(e)) +=
              c[0] * t.term.columns.col(0).matrix().transpose();
    }
  }
  for (Eigen::Index e = 0; e < estimate_.delay.rows(); ++e)
    for (Eigen::Index k = 0; k < evidence_->rows(); ++k)
      if (estimate_.delay(e, k) != 0)
        estimate_.additions(e, k) +=
            added_by_delay(*evidence_, static_cast<std::size_t>(e), k, estimate_.delay(e, k));
  if (estimate_.slope.size() == 0 || estimate_.delay != before)
    estimate_.slope = slopes_by_delay(*evidence_, estimate_.delay);
  estimate_.chain = as_built(model_->chain, built);
  for (std::size_t i = 0; i < terms_.size(); ++i)
    if (const TipTerm& t = terms_[i];
        t.kind == TipTerm::Kind::frame_tilt || t.kind == TipTerm::Kind::axis_tilt)
      tilt(estimate_.chain.joints[t.where], t.kind, t.directions * coefficients(i));
}

/// Columns of the nuisance parameters: the tracker's frames and free encoder zeros.
void TipModel::arrange_nuisance() {
  std::vector<TipTerm> free;
  if (frames_.base) free.push_back({TipTerm::Kind::base, {}, 0});
  if (frames_.target) free.push_back({TipTerm::Kind::tool, {}, 0});
  for (std::size_t i = 0; i < evidence_->encoders.size(); ++i)
    if (evidence_->judged(i) && !evidence_->encoders[i].encoder.zero_known) {
      free.push_back({TipTerm::Kind::encoder, {}, i});
      free.back().term.columns = Eigen::ArrayXXd::Ones(evidence_->rows(), 1);
    }
  Eigen::Index count = 0;
  for (const TipTerm& t : free) count += t.size();
  nuisance_.resize(y_.size(), count);
  Eigen::Index at = 0;
  for (const TipTerm& t : free) {
    nuisance_.middleCols(at, t.size()) = columns(t);
    at += t.size();
  }
}

/// Curvature changes little from estimate to estimate: that of the first is kept.
void TipModel::find_second_order() {
  auto all = std::make_shared<std::vector<SecondOrder>>();
  const Eigen::VectorXd steps = resolutions(model_->transmission);
  for (Eigen::Index k = 0; k < evidence_->rows(); ++k)
    all->push_back(second_order(estimate_.pose(*evidence_, k), estimate_.chain, evidence_->to_joints, steps));
  second_order_ = std::move(all);
}

/// Computes poses, entries and columns at the current estimate.
void TipModel::linearize() {
  const auto coordinates = static_cast<Eigen::Index>(evidence_->axes.size());
  const Eigen::Index rows = evidence_->rows();
  auto poses = std::make_shared<std::vector<TipPose>>();
  poses->reserve(static_cast<std::size_t>(rows));
  turn_.resize(static_cast<std::size_t>(rows));
  y_.resize(rows * coordinates);
  read_.resize(rows * coordinates, evidence_->to_joints.cols());
  known_.resize(rows * coordinates);
  const Eigen::VectorXd quantization = resolutions(model_->transmission).array().square() / 12;
  const Eigen::VectorXd reference = evidence_->joint_noise.array().square();
  const Eigen::VectorXd mean = mean_errors(model_->transmission);
  if (!second_order_) find_second_order();
  for (Eigen::Index k = 0; k < rows; ++k) {
    const TipPose p = estimate_.pose(*evidence_, k);
    const SecondOrder& second = (*second_order_)[static_cast<std::size_t>(k)];
    const Eigen::Matrix3d all = p.encoders * quantization.asDiagonal() * p.encoders.transpose() +
                                p.joints * reference.asDiagonal() * p.joints.transpose() + second.covariance;
    // A counter that truncates reads too low by half a count on average.
    const Eigen::Vector3d tip = p.tip - p.encoders * mean - second.mean;
    const Eigen::MatrixXd tracked = all(evidence_->axes, evidence_->axes);
    const SymmetricEigen axes = symmetric_eigen(tracked);
    auto& turn = turn_[static_cast<std::size_t>(k)];
    turn.setZero(coordinates, 3);
    turn(Eigen::all, evidence_->axes) = axes.vectors.transpose();
    y_.segment(k * coordinates, coordinates) = turn * tip - axes.vectors.transpose() * evidence_->tip.col(k);
    known_.segment(k * coordinates, coordinates) = axes.values.cwiseMax(0);
    read_.middleRows(k * coordinates, coordinates).noalias() = turn * p.encoders;
    poses->push_back(p);
  }
  poses_ = std::move(poses);
  for (std::size_t i = 0; i < terms_.size(); ++i)
    update_columns(terms_[i], coefficients(i), *evidence_, estimate_);
  term_columns_.clear();
  for (const TipTerm& t : terms_) term_columns_.push_back(columns(t));
  arrange_nuisance();
  // What the estimate has is back in the entries; it has the machine, not what displaces the tracker.
  for (std::size_t i = 0; i < terms_.size(); ++i)
    if (!terms_[i].of_record()) y_ += term_columns_[i] * coefficients(i);
}

/// Brings the tracker's frame and its target to where the solution has them.
void TipModel::move_frames() {
  if (frames_.target) estimate_.tool += solution_.theta.segment<3>(frames_.size() - 3);
  if (!frames_.base) return;
  const Eigen::Vector3d turn = solution_.theta.segment<3>(3);
  Eigen::Isometry3d shift = Eigen::Isometry3d::Identity();
  shift.translate(solution_.theta.head<3>());
  if (turn.norm() > 0) shift.rotate(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
  estimate_.base = shift * estimate_.base;
}

void TipModel::refit() {
  solution_ = trial({}, {});
  theta_ = solution_.theta.tail(theta_.size());
  projection_ = std::make_shared<const Projection>(projection({}));
}

void TipModel::fit() {
  // Columns along the readings become those along the corrected path by the first linearization: the second
  // one sees it.
  const bool follows_path = std::any_of(terms_.begin(), terms_.end(), [](const TipTerm& t) {
    return t.kind == TipTerm::Kind::encoder && !t.term.constant && !t.term.step;
  });
  for (int i = 0; i < 20; ++i) {
    update_estimate();
    linearize();
    solution_ = trial({}, {});
    const Eigen::VectorXd step = solution_.theta.tail(theta_.size()) - theta_;
    theta_ = solution_.theta.tail(theta_.size());
    double moved = 0;
    const Eigen::MatrixXd all = all_columns();
    Eigen::VectorXd steps = solution_.theta;
    steps.tail(theta_.size()) = step;
    if (all.cols() > 0) moved = (all * steps).norm() / std::sqrt(static_cast<double>(y_.size()));
    move_frames();
    if ((i > 0 || !follows_path) && moved < 0.02 * std::sqrt(known_.mean() + std::pow(solution_.sigma, 2)))
      break;
  }
  projection_ = std::make_shared<const Projection>(projection({}));
}

/// Quantization errors of all encoders in every row, for one draw of their sub-count phases, less their mean.
Eigen::MatrixXd TipModel::drawn_errors(std::uint64_t draw) const {
  Eigen::MatrixXd errors = Eigen::MatrixXd::Zero(evidence_->rows(), evidence_->to_joints.cols());
  for (std::size_t i = 0; i < evidence_->encoders.size(); ++i) {
    if (!evidence_->judged(i)) continue;
    const Evidence& e = evidence_->encoders[i];
    const Eigen::ArrayXd phases = drawn_phases(e, stream_seed(seed_, "tip phases", i), draw);
    for (Eigen::Index k = 0; k < e.rows(); ++k) {
      const double x = e.path[k] + e.step() * phases[k];
      errors(k, static_cast<Eigen::Index>(i)) = quantize(e.encoder, x) - x - mean_error(e.encoder);
    }
  }
  return errors;
}

void TipModel::draw_surrogates() {
  surrogates_.setZero(y_.size(), evidence_->ordered ? path_draws : 0);
  const auto coordinates = static_cast<Eigen::Index>(evidence_->axes.size());
  for (Eigen::Index d = 0; d < surrogates_.cols(); ++d) {
    const Eigen::MatrixXd errors = drawn_errors(static_cast<std::uint64_t>(d));
    for (Eigen::Index k = 0; k < evidence_->rows(); ++k) {
      const auto row = static_cast<std::size_t>(k);
      const Eigen::VectorXd delta = errors.row(k).transpose();
      const SecondOrder& second = (*second_order_)[row];
      Eigen::Vector3d at_tip = (*poses_)[row].encoders * delta - second.mean;
      for (Eigen::Index a = 0; a < delta.size(); ++a)
        if (delta[a] != 0) at_tip -= 0.5 * delta[a] * (second.hessian[static_cast<std::size_t>(a)] * delta);
      surrogates_.col(d).segment(k * coordinates, coordinates) = turn_[row] * at_tip;
    }
  }
}

}  // namespace qerr
