#include "tip_model.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "qerr/core/random.hpp"
#include "qerr/simulate/sensing.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index most_blocks = 64;
constexpr Eigen::Index draws = 40;  // of quantization along the path
constexpr double nothing_left = 1e-5;

}  // namespace

TipModel::TipModel(const OperationalModel& model, const TipEvidence& evidence, bool frames)
    : model_(&model), evidence_(&evidence), frames_(frames) {
  belief_.chain = model.chain;
  belief_.additions.setZero(static_cast<Eigen::Index>(evidence.encoders.size()), evidence.rows());
  theta_.resize(0);
  if (frames_) align();
  fit();
  draw_surrogates();
}

/// Rotation and translation that bring the model's tip upon the tracked one, where it is far off: a start for
/// the fit, which turns only a little at a time (Kabsch).
void TipModel::align() {
  if (evidence_->axes.size() < 3) return;
  Eigen::Matrix3Xd tip(3, evidence_->rows());
  for (Eigen::Index k = 0; k < evidence_->rows(); ++k) tip.col(k) = belief_.pose(*evidence_, k).tip;
  const Eigen::Matrix3Xd seen = evidence_->tip;
  const Eigen::Matrix3Xd centred = seen.colwise() - seen.rowwise().mean();
  if ((tip - seen).norm() < 0.02 * centred.norm()) return;
  const Eigen::Matrix4d moved = Eigen::umeyama(tip, seen, false);
  belief_.base.matrix() = moved;
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
  terms_.push_back(std::move(term));
}

void TipModel::remove(std::size_t term) {
  const Eigen::Index at = position(term) - nuisance_.cols(), gone = terms_[term].size();
  Eigen::VectorXd kept(theta_.size() - gone);
  kept << theta_.head(at), theta_.tail(theta_.size() - at - gone);
  theta_ = kept;
  terms_.erase(terms_.begin() + static_cast<std::ptrdiff_t>(term));
}

void TipModel::exchange(std::size_t term, TipTerm other, const Eigen::VectorXd& coefficients) {
  remove(term);
  add(std::move(other), coefficients);
}

/// What the coefficients say of links and readings.
void TipModel::believe() {
  std::vector<Effect> built;
  belief_.additions.setZero();
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    TipTerm& t = terms_[i];
    const Eigen::VectorXd c = coefficients(i);
    if (t.way == TipTerm::Way::geometry) {
      built.push_back(t.term.effect);
      t.term.fill(built.back(), c);
    } else if (t.way == TipTerm::Way::encoder) {
      belief_.additions.row(static_cast<Eigen::Index>(t.where)) += (t.term.columns.matrix() * c).transpose();
    }
  }
  belief_.chain = as_built(model_->chain, built);
}

void TipModel::linearize() {
  const auto coordinates = static_cast<Eigen::Index>(evidence_->axes.size());
  const Eigen::Index rows = evidence_->rows();
  auto poses = std::make_shared<std::vector<TipPose>>();
  poses->reserve(static_cast<std::size_t>(rows));
  turn_.resize(static_cast<std::size_t>(rows));
  y_.resize(rows * coordinates);
  known_.resize(rows * coordinates);
  const Eigen::VectorXd quantization = resolutions(model_->transmission).array().square() / 12;
  const Eigen::VectorXd reference = evidence_->joint_noise.array().square();
  const Eigen::VectorXd mean = mean_errors(model_->transmission);
  for (Eigen::Index k = 0; k < rows; ++k) {
    const TipPose p = belief_.pose(*evidence_, k);
    const Eigen::Matrix3d all = p.encoders * quantization.asDiagonal() * p.encoders.transpose() +
                                p.joints * reference.asDiagonal() * p.joints.transpose();
    // A counter that truncates reads too low by half a count on average.
    const Eigen::Vector3d tip = p.tip - p.encoders * mean;
    const Eigen::MatrixXd seen = all(evidence_->axes, evidence_->axes);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(seen);
    Eigen::MatrixXd turn = Eigen::MatrixXd::Zero(coordinates, 3);
    turn(Eigen::all, evidence_->axes) = axes.eigenvectors().transpose();
    y_.segment(k * coordinates, coordinates) =
        turn * tip - axes.eigenvectors().transpose() * evidence_->tip.col(k);
    known_.segment(k * coordinates, coordinates) = axes.eigenvalues().cwiseMax(0);
    turn_[static_cast<std::size_t>(k)] = std::move(turn);
    poses->push_back(p);
  }
  poses_ = std::move(poses);
  for (std::size_t i = 0; i < terms_.size(); ++i) renew(terms_[i], coefficients(i), *evidence_, belief_);
  term_columns_.clear();
  for (const TipTerm& t : terms_) term_columns_.push_back(columns(t));
  std::vector<TipTerm> free;
  if (frames_) free = {{TipTerm::Way::base, {}, 0, 0}, {TipTerm::Way::tool, {}, 0, 0}};
  for (std::size_t i = 0; i < evidence_->encoders.size(); ++i)
    if (evidence_->judged(i) && !evidence_->encoders[i].encoder.zero_known) {
      free.push_back({TipTerm::Way::encoder, {}, i, 0});
      free.back().term.columns = Eigen::ArrayXXd::Ones(rows, 1);
    }
  Eigen::Index count = 0;
  for (const TipTerm& t : free) count += t.size();
  nuisance_.resize(y_.size(), count);
  Eigen::Index at = 0;
  for (const TipTerm& t : free) {
    nuisance_.middleCols(at, t.size()) = columns(t);
    at += t.size();
  }
  for (std::size_t i = 0; i < terms_.size(); ++i) y_ += term_columns_[i] * coefficients(i);
}

void TipModel::fit() {
  for (int i = 0; i < 20; ++i) {
    believe();
    linearize();
    solution_ = trial({}, {});
    const Eigen::VectorXd step = solution_.theta.tail(theta_.size()) - theta_;
    theta_ = solution_.theta.tail(theta_.size());
    double moved = 0;
    const Eigen::MatrixXd all = all_columns();
    Eigen::VectorXd steps = solution_.theta;
    steps.tail(theta_.size()) = step;
    if (all.cols() > 0) moved = (all * steps).norm() / std::sqrt(static_cast<double>(y_.size()));
    if (frames_) {
      const Eigen::VectorXd s = solution_.theta.head<9>();
      const Eigen::Vector3d turn = s.segment<3>(3);
      Eigen::Isometry3d shift = Eigen::Isometry3d::Identity();
      shift.translate(s.head<3>());
      if (turn.norm() > 0) shift.rotate(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
      belief_.base = shift * belief_.base;
      belief_.tool += s.tail<3>();
    }
    if (moved < 0.02 * std::sqrt(known_.mean() + std::pow(solution_.sigma, 2))) break;
  }
}

Eigen::MatrixXd TipModel::columns(const TipTerm& t) const {
  const auto coordinates = static_cast<Eigen::Index>(evidence_->axes.size());
  Eigen::MatrixXd out(y_.size(), t.size());
  for (Eigen::Index k = 0; k < evidence_->rows(); ++k)
    out.middleRows(k * coordinates, coordinates) =
        turn_[static_cast<std::size_t>(k)] * t.at((*poses_)[static_cast<std::size_t>(k)], k);
  return out;
}

Eigen::MatrixXd TipModel::all_columns(const std::vector<std::size_t>& without) const {
  Eigen::MatrixXd all = nuisance_;
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    if (std::find(without.begin(), without.end(), i) != without.end()) continue;
    all.conservativeResize(Eigen::NoChange, all.cols() + terms_[i].size());
    all.rightCols(terms_[i].size()) = term_columns_[i];
  }
  return all;
}

TipSolution TipModel::trial(const std::vector<std::size_t>& without, const Eigen::MatrixXd& extra) const {
  Eigen::MatrixXd x = all_columns(without);
  if (extra.cols() > 0) {
    x.conservativeResize(Eigen::NoChange, x.cols() + extra.cols());
    x.rightCols(extra.cols()) = extra;
  }
  const double least = std::max({0.5 * evidence_->noise, 0.3 * evidence_->grid, 1e-9});
  return solve(x, y_, known_, least);
}

Eigen::MatrixXd TipModel::beyond(const std::vector<std::size_t>& without,
                                 const Eigen::MatrixXd& columns) const {
  const Eigen::MatrixXd present = all_columns(without);
  if (present.cols() == 0) return columns;
  const Eigen::MatrixXd weighted = solution_.weight.asDiagonal() * present;
  const NormalInverse normal(present.transpose() * weighted);
  Eigen::MatrixXd left = columns - present * (normal.inverse * (weighted.transpose() * columns));
  const Eigen::VectorXd root = solution_.weight.cwiseSqrt();
  for (Eigen::Index i = 0; i < left.cols(); ++i)
    if (root.cwiseProduct(left.col(i)).norm() < nothing_left * root.cwiseProduct(columns.col(i)).norm())
      left.col(i).setZero();
  return left;
}

double TipModel::inflation(const TipSolution& s, const Eigen::MatrixXd& columns, Eigen::Index coordinates) {
  const Eigen::VectorXd pull = s.weight.cwiseProduct(s.rest);
  const Eigen::Index rows = pull.size() / coordinates, blocks = std::min(most_blocks, rows / 8);
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

void TipModel::draw_surrogates() {
  surrogates_.setZero(y_.size(), evidence_->ordered ? draws : 0);
  const auto coordinates = static_cast<Eigen::Index>(evidence_->axes.size());
  for (std::size_t i = 0; i < evidence_->encoders.size(); ++i) {
    if (!evidence_->judged(i)) continue;
    const Evidence& e = evidence_->encoders[i];
    TipTerm unit{TipTerm::Way::encoder, {}, i, 0};
    unit.term.columns = Eigen::ArrayXXd::Ones(e.rows(), 1);
    const Eigen::VectorXd column = columns(unit);
    for (Eigen::Index d = 0; d < surrogates_.cols(); ++d) {
      const double phase = e.step() * unit_interval(random_bits(2, i, static_cast<std::uint64_t>(d)));
      for (Eigen::Index k = 0; k < e.rows(); ++k) {
        const double x = e.path[k] + phase;
        surrogates_.col(d).segment(k * coordinates, coordinates) +=
            (quantize(e.encoder, x) - x - mean_error(e.encoder)) *
            column.segment(k * coordinates, coordinates);
      }
    }
  }
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

}  // namespace qerr
