#include "diagnose/inference/tip/tip_candidates.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace qerr {

namespace {

/// What a unit of each encoder's reading does for the likelihood: encoders x rows.
Eigen::MatrixXd encoder_scores(const TipModel& model) {
  const TipEvidence& e = model.evidence();
  const auto coordinates = static_cast<Eigen::Index>(e.axes.size());
  const Eigen::VectorXd pull = model.solution().weight.cwiseProduct(model.solution().residual);
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(e.encoders.size()), e.rows());
  for (std::size_t i = 0; i < e.encoders.size(); ++i) {
    if (!e.judged(i)) continue;
    TipTerm unit{TipTerm::Kind::encoder, {}, i};
    unit.term.columns = Eigen::ArrayXXd::Ones(e.rows(), 1);
    const Eigen::MatrixXd column = model.columns(unit);
    for (Eigen::Index k = 0; k < e.rows(); ++k)
      scores(static_cast<Eigen::Index>(i), k) =
          column.col(0).segment(k * coordinates, coordinates).dot(pull.segment(k * coordinates, coordinates));
  }
  return scores;
}

/// The step of lost counts with the largest score, orthogonal to a constant.
std::optional<Term> strongest_tip_step(const Evidence& e, const Eigen::VectorXd& score) {
  const double all = score.sum();
  const auto rows = static_cast<double>(score.size());
  double after = 0, best = 0;
  Eigen::Index at = 0;
  for (Eigen::Index k = score.size(); k-- > 8;) {
    after += score[k];
    if (k + 8 > score.size()) continue;
    const double part = static_cast<double>(score.size() - k) / rows;
    const double gain = std::pow(after - part * all, 2) / (part * (1 - part));
    if (gain > best) best = gain, at = k;
  }
  if (at == 0) return std::nullopt;
  return step_term(e, 0.5 * (e.time[at] + e.time[at - 1]));
}

/// The strongest free order of the joint, over what its range of motion resolves.
std::optional<Term> strongest_tip_order(const Evidence& e, const Eigen::VectorXd& score) {
  const double range = e.path.maxCoeff() - e.path.minCoeff();
  if (range < 20 * e.step()) return std::nullopt;
  const double spacing = std::numbers::pi / range;
  const auto some = Eigen::seq(0, Eigen::last, std::max<Eigen::Index>(1, e.rows() / 2048));
  const Eigen::ArrayXd angle = e.path(some), weight = score(some).array();
  const auto power = [&](const Eigen::ArrayXd& cosine, const Eigen::ArrayXd& sine) {
    return std::pow((weight * cosine).sum(), 2) + std::pow((weight * sine).sum(), 2);
  };
  // An order of the grid is the one before it, turned by the same angle in each row.
  const Eigen::ArrayXd turn_cosine = (spacing * angle).cos(), turn_sine = (spacing * angle).sin();
  Eigen::ArrayXd cosine = turn_cosine, sine = turn_sine, next(angle.size());
  double best = 0, best_order = 0;
  for (int i = 2; i < scanned_at_tip && i * spacing * e.step() < 1.5; ++i) {
    next = cosine * turn_cosine - sine * turn_sine;
    sine = sine * turn_cosine + cosine * turn_sine;
    cosine.swap(next);
    if (const double here = power(cosine, sine); here > best) best = here, best_order = i * spacing;
  }
  for (double step = spacing / 2; step > spacing / 100; step /= 2)
    for (const double order : {best_order - step, best_order + step})
      if (const double here = power((order * angle).cos(), (order * angle).sin()); here > best)
        best = here, best_order = order;
  return free_order_term(e, best_order);
}

bool same(const TipTerm& a, const TipTerm& b) {
  const Effect &x = a.term.effect, &y = b.term.effect;
  return a.kind == b.kind && a.where == b.where && a.directions == b.directions && x.type == y.type &&
         x.choices == y.choices && x.number_or("order", 0) == y.number_or("order", 0) &&
         x.number_or("time_constant", 0) == y.number_or("time_constant", 0) &&
         x.number_or("time", 0) == y.number_or("time", 0);
}

}  // namespace

bool chosen(const TipModel& model, const TipTerm& t) {
  return std::any_of(model.terms().begin(), model.terms().end(),
                     [&](const TipTerm& other) { return same(other, t); });
}

std::vector<TipTerm> tip_candidates(const TipModel& model) {
  const TipEvidence& e = model.evidence();
  std::vector<TipTerm> all = tip_terms(e, model.estimate());
  for (TipTerm& t : tilt_terms(model.nominal())) all.push_back(std::move(t));
  if (e.ordered && e.rows() >= 500) {
    const Eigen::MatrixXd scores = encoder_scores(model);
    for (std::size_t i = 0; i < e.encoders.size(); ++i) {
      if (!e.judged(i)) continue;
      const Evidence own = corrected_evidence(e, model.estimate(), i);
      const Eigen::VectorXd score = scores.row(static_cast<Eigen::Index>(i));
      if (auto step = strongest_tip_step(own, score))
        all.push_back({TipTerm::Kind::encoder, std::move(*step), i});
      if (auto order = strongest_tip_order(own, score))
        all.push_back({TipTerm::Kind::encoder, std::move(*order), i});
    }
  }
  std::erase_if(all, [&](const TipTerm& t) { return chosen(model, t); });
  return all;
}

}  // namespace qerr
