#include "diagnose/inference/tip/tip_alternatives.hpp"

#include <algorithm>
#include <numbers>

#include "core/random.hpp"
#include "core/solve.hpp"
#include "diagnose/inference/tip/tip_candidates.hpp"
#include "diagnose/inference/tip/tip_weight.hpp"

namespace qerr {

namespace {

constexpr double as_good = 6;  // of log-likelihood

/// Evidence with random poses: terms that these cannot distinguish, no record can.
TipEvidence random_poses(const TipEvidence& e, const Chain& chain, std::uint64_t seed) {
  TipEvidence wide = e;
  const Eigen::Index rows = std::min<Eigen::Index>(100, e.rows());
  wide.tip.setZero(e.tip.rows(), rows);
  wide.joints.resize(e.joints.rows(), rows);
  for (Eigen::Index j = 0; j < wide.joints.rows(); ++j)
    for (Eigen::Index k = 0; k < rows; ++k) {
      const double u =
          unit_interval(random_bits(seed, static_cast<std::uint64_t>(k), static_cast<std::uint64_t>(j)));
      wide.joints(j, k) =
          (2 * u - 1) * (chain.independent[static_cast<std::size_t>(j)].prismatic() ? 0.5 : std::numbers::pi);
    }
  for (Evidence& own : wide.encoders)
    for (Eigen::ArrayXd* series : series_of(own))
      if (series->size() > 0) series->conservativeResize(rows);
  return wide;
}

TipTerm shortened(TipTerm t, Eigen::Index rows) {
  if (t.kind == TipTerm::Kind::encoder) t.term.columns = t.term.columns.topRows(rows).eval();
  return t;
}

/// Whether another term can replace a chosen one in every pose; both depend on the pose alone.
bool everywhere(const OperationalModel& model, const TipModel& fitted, std::size_t term,
                const TipTerm& other) {
  if (!fitted.terms()[term].kinematic() || !other.kinematic()) return false;
  const TipEvidence wide =
      random_poses(fitted.evidence(), model.chain, stream_seed(fitted.seed(), "tip poses"));
  TipModel poses(model, wide, UnknownFrames::none, fitted.seed());
  const Eigen::MatrixXd target = poses.columns(shortened(fitted.terms()[term], wide.rows()));
  Eigen::MatrixXd rest = poses.columns(shortened(other, wide.rows()));
  const auto append = [&](const TipTerm& t) {
    rest.conservativeResize(Eigen::NoChange, rest.cols() + t.size());
    rest.rightCols(t.size()) = poses.columns(t);
  };
  for (std::size_t i = 0; i < fitted.terms().size(); ++i)
    if (i != term && fitted.terms()[i].kinematic()) append(shortened(fitted.terms()[i], wide.rows()));
  if (fitted.frames() == UnknownFrames::all) append({TipTerm::Kind::base, {}, 0});
  if (fitted.frames() != UnknownFrames::none) append({TipTerm::Kind::tool, {}, 0});
  const Eigen::VectorXd fit = least_norm_solution(rest, target);
  return (target - rest * fit).norm() < 1e-6 * target.norm();
}

}  // namespace

void find_tip_alternatives(const OperationalModel& model, TipSelection& s) {
  TipModel& m = s.model;
  for (int round = 0; round < 8; ++round) {
    s.alternatives.clear();
    const std::vector<TipTerm> others = tip_terms(m.evidence(), m.estimate());
    bool exchanged = false;
    for (std::size_t i = 0; i < m.terms().size() && !exchanged; ++i) {
      const double correlated = variance_inflation(m, i);
      const TipSolution without = m.trial({i}, {});
      TipSolution at_weights = without;
      at_weights.weight = m.solution().weight;
      const double own = gain_of(at_weights, m.beyond({i}, m.columns(m.terms()[i])));
      for (const TipTerm& other : others) {
        if (chosen(m, other)) continue;
        const Eigen::MatrixXd columns = m.columns(other);
        if (gain_of(at_weights, m.beyond({i}, columns)) < own - correlated * (2 * as_good + 20)) continue;
        const TipSolution swapped = m.trial({i}, columns);
        const double loss = (m.solution().log_likelihood - swapped.log_likelihood) / correlated +
                            price(m, columns.cols()) - price(m, m.terms()[i].size()) + penalty(m, other) -
                            penalty(m, m.terms()[i]);
        if (loss < -better_by && round < 7) {
          const Eigen::VectorXd theta = swapped.theta.tail(columns.cols());
          m.exchange(i, other, theta);
          m.fit();
          exchanged = true;
          break;
        }
        if (loss < as_good && m.terms()[i].term.named()) s.alternatives.push_back({i, other, loss, false});
      }
    }
    if (!exchanged) break;
  }
  for (TipAlternative& a : s.alternatives) a.everywhere = everywhere(model, m, a.term, a.other);
}

}  // namespace qerr
