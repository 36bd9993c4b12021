#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "diagnose/inference/tip/tip_select.hpp"
#include "diagnose/inference/tip/tip_weight.hpp"
#include "support/record_figures.hpp"

/// The figures of models of a tracked tip: rows of tests/golden/tip_model_figures.csv.
namespace qerr::testing {

/// 1e-5 of each: fits end where they move by less than a part of the noise.
inline const Measured& figures_of_tips() {
  static const Measured all("tip_model_figures.csv", 1e-5);
  return all;
}

inline std::string name_of_tip_term(const TipTerm& t) {
  std::string name = std::to_string(static_cast<int>(t.kind)) + ' ' + std::to_string(t.where) + ' ';
  name += t.term.named() ? t.term.effect.type : t.term.unnamed;
  for (const auto& [key, choice] : t.term.effect.choices) name += ' ' + choice;
  std::replace(name.begin(), name.end(), ',', ';');
  return name;
}

/// Tells terms apart that differ in a number only.
inline double number_of(const TipTerm& t) {
  double sum = 0;
  for (const auto& [key, number] : t.term.effect.numbers) sum += std::abs(number);
  return std::round(1e3 * sum);
}

/// One number of all entries, which depends on their order.
inline double digest_of(const Eigen::MatrixXd& m) {
  double sum = 0;
  for (Eigen::Index i = 0; i < m.size(); ++i) {
    const double at = static_cast<double>(i % 17) + 1;
    sum += at * std::abs(m.data()[i]);
  }
  return sum / static_cast<double>(std::max<Eigen::Index>(m.size(), 1));
}

inline void expect_model(const RecordFigures& figure, const std::string& start, const TipModel& m) {
  const TipSolution& s = m.solution();
  figure(start + "sigma", s.sigma);
  figure(start + "log likelihood", s.log_likelihood);
  figure(start + "rank", static_cast<double>(s.rank));
  figure(start + "nuisance", static_cast<double>(m.nuisance()));
  figure(start + "residual", s.residual.norm());
  figure(start + "weights", s.weight.mean());
  figure(start + "entries", m.entries().norm());
  figure(start + "value", m.value(s, m.size()));
  figure(start + "tool", m.estimate().tool.norm());
  figure(start + "base", m.estimate().base.translation().norm());
  figure(start + "turn", Eigen::AngleAxisd(m.estimate().base.linear()).angle());
  figure(start + "additions", m.estimate().additions.norm());
  for (std::size_t i = 0; i < m.terms().size(); ++i) {
    const TipTerm& t = m.terms()[i];
    const std::string name = start + std::to_string(i) + ' ' + name_of_tip_term(t) + ' ';
    const Eigen::MatrixXd columns = m.columns(t);
    figure(name + "coefficients", m.coefficients(i).norm());
    figure(name + "columns", columns.norm());
    figure(name + "without", m.trial({i}, {}).log_likelihood);
    figure(name + "beyond", m.beyond(m.projection({i}), columns).norm());
    if (t.term.effect.numbers.count("order") > 0) figure(name + "order", t.term.effect.number("order"));
    if (t.term.effect.numbers.count("time") > 0) figure(name + "time", t.term.effect.number("time"));
  }
}

/// What `select_tip` weighs of every candidate.
inline void expect_candidates(const RecordFigures& figure, const std::string& start, const TipModel& m) {
  const auto coordinates = static_cast<Eigen::Index>(m.evidence().axes.size());
  std::vector<TipTerm> all = tip_candidates(m);
  figure(start + "candidates", static_cast<double>(all.size()));
  int number = 0;
  for (const TipTerm& t : all) {
    const std::string name =
        start + "candidate " + std::to_string(++number) + ' ' + name_of_tip_term(t) + ' ';
    const Eigen::MatrixXd columns = m.columns(t), beyond = m.beyond(columns);
    figure(name + "columns", columns.norm());
    // Where a column depends on the others, its rest is zero or rounding errors.
    if (beyond.norm() < 1e-4 * columns.norm()) continue;
    const TipSolution s = m.trial({}, columns);
    figure(name + "beyond", beyond.norm());
    figure(name + "gain", gain_of(m.solution(), beyond));
    figure(name + "log likelihood", s.log_likelihood);
    figure(name + "of blocks", TipModel::variance_inflation(s, columns, coordinates));
    figure(name + "of quantization", m.quantization_inflation(beyond));
    figure(name + "inflation", variance_inflation(m, s, columns));
    figure(name + "signal", signal_to_noise(s, beyond, s.theta.tail(t.size())));
    figure(name + "required", required_signal_to_noise(t) + 100 * penalty(m, t));
    if (t.term.effect.numbers.count("order") > 0) figure(name + "order", t.term.effect.number("order"));
    if (t.term.effect.numbers.count("time") > 0) figure(name + "time", t.term.effect.number("time"));
  }
}

inline void expect_evidence(const RecordFigures& figure, const TipEvidence& e) {
  figure("rows", static_cast<double>(e.rows()));
  figure("tip", digest_of(e.tip));
  figure("joints", digest_of(e.joints));
  figure("joint noise", e.joint_noise.norm());
  figure("to joints", digest_of(e.to_joints));
  figure("noise", e.noise);
  figure("log resolution", e.log_resolution);
  for (std::size_t i = 0; i < e.encoders.size(); ++i) {
    const Evidence& own = e.encoders[i];
    const std::string name = "encoder " + std::to_string(i) + ' ';
    figure(name + "judged", e.judged(i) ? 1 : 0);
    figure(name + "noise", own.noise);
    figure(name + "path", digest_of(own.path.matrix()));
    figure(name + "measured", digest_of(own.measured.matrix()));
    figure(name + "time", digest_of(own.time.matrix()));
    figure(name + "velocity", digest_of(own.velocity.matrix()));
    figure(name + "direction", digest_of(own.direction.matrix() + Eigen::VectorXd::Ones(own.rows())));
    figure(name + "effort", digest_of(own.effort.matrix()));
    figure(name + "temperature", digest_of(own.temperature.matrix()));
  }
}

/// The selection; its p-values and losses against their definitions.
inline void expect_selection(const RecordFigures& figure, const TipSelection& s) {
  const TipModel& m = s.model;
  figure("frames", m.frames().base ? 2 : m.frames().target);
  expect_model(figure, "selected ", m);
  const auto lost = [&](std::size_t term, const Eigen::MatrixXd& instead) {
    return (m.solution().log_likelihood - m.trial({term}, instead).log_likelihood) /
           variance_inflation(m, term);
  };
  for (std::size_t i = 0; i < s.p_values.size(); ++i) {
    const double p = p_value(lost(i, {}), m.terms()[i].size());
    EXPECT_NEAR(s.p_values[i], p, 1e-9 * p);
  }
  for (const TipAlternative& a : s.alternatives) {
    const TipTerm& own = m.terms()[a.term];
    const double loss = lost(a.term, m.columns(a.other)) + price(m, a.other.size()) - price(m, own.size()) +
                        penalty(m, a.other) - penalty(m, own);
    EXPECT_NEAR(a.loss, loss, 1e-6);
    EXPECT_LT(a.loss, 6);  // of log-likelihood: what fits as well
    figure("or " + name_of_tip_term(a.other) + " of " + std::to_string(static_cast<int>(number_of(a.other))) +
               " for " + std::to_string(a.term),
           a.everywhere ? 1 : 0);
  }
  figure("alternatives", static_cast<double>(s.alternatives.size()));
}

}  // namespace qerr::testing
