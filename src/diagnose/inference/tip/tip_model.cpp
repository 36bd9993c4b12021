#include "diagnose/inference/tip/tip_model.hpp"

#include <algorithm>
#include <cmath>

namespace qerr {

namespace {

constexpr Eigen::Index most_tip_blocks = 64;
constexpr double negligible = 1e-5;

}  // namespace

TipModel::TipModel(const OperationalModel& model, const TipEvidence& evidence, UnknownFrames frames,
                   std::uint64_t seed)
    : model_(&model), evidence_(&evidence), frames_(frames), seed_(seed) {
  estimate_.chain = model.chain;
  estimate_.additions.setZero(static_cast<Eigen::Index>(evidence.encoders.size()), evidence.rows());
  theta_.resize(0);
  if (frames_ == UnknownFrames::all) align();
  fit();
  draw_surrogates();
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
  const double least = std::max({0.5 * evidence_->noise, 0.3 * evidence_->log_resolution, 1e-9});
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
    if (root.cwiseProduct(left.col(i)).norm() < negligible * root.cwiseProduct(columns.col(i)).norm())
      left.col(i).setZero();
  return left;
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

}  // namespace qerr
