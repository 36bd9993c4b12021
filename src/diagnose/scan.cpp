#include "scan.hpp"

#include <cmath>
#include <complex>
#include <numbers>

namespace qerr {

namespace {

constexpr Eigen::Index most_rows = 8192;

/// |sum of scores e^{i rate argument}|^2 over an even part of the rows.
double power(const Eigen::ArrayXd& score, const Eigen::ArrayXd& argument, double rate) {
  const Eigen::Index stride = std::max<Eigen::Index>(1, score.size() / most_rows);
  double sine = 0, cosine = 0;
  for (Eigen::Index k = 0; k < score.size(); k += stride) {
    sine += score[k] * std::sin(rate * argument[k]);
    cosine += score[k] * std::cos(rate * argument[k]);
  }
  return sine * sine + cosine * cosine;
}

/// The rate of most power among multiples of a quarter of what the argument's range resolves, then finer.
double strongest_rate(const Eigen::ArrayXd& score, const Eigen::ArrayXd& argument, double least,
                      double most) {
  const double range = argument.maxCoeff() - argument.minCoeff();
  if (!(range > 0)) return 0;
  const double spacing = 0.5 * std::numbers::pi / range;
  // Rates step by step: every row's e^{i rate argument} turns by the same angle each time.
  const Eigen::Index stride = std::max<Eigen::Index>(1, score.size() / most_rows),
                     rows = score.size() / stride;
  Eigen::ArrayXcd phasor(rows), turn(rows);
  for (Eigen::Index k = 0; k < rows; ++k) {
    turn[k] = std::polar(1.0, spacing * argument[k * stride]);
    phasor[k] = score[k * stride] * turn[k];
  }
  double best = 0, rate = 0;
  for (int i = 2; i < scanned_hypotheses; ++i) {
    phasor *= turn;
    const double here = i * spacing;
    if (here < least) continue;
    if (here > most) break;
    if (const double p = std::norm(phasor.sum()); p > best) best = p, rate = here;
  }
  for (double step = spacing / 2; step > spacing / 200; step /= 2)
    for (const double here : {rate - step, rate + step})
      if (const double p = power(score, argument, here); p > best) best = p, rate = here;
  return rate;
}

}  // namespace

std::optional<Term> strongest_step(const Evidence& e, const Explanation& model) {
  if (!e.ordered) return std::nullopt;
  // A step at k adds the scores behind it, less what a constant would take.
  const IntervalLikelihood& l = model.plain();
  const double all = l.score.sum(), weight = l.curvature.sum();
  constexpr Eigen::Index edge = 8;  // rows that a step must leave on either side
  double behind = 0, weight_behind = 0, best = 0;
  Eigen::Index at = 0;
  for (Eigen::Index k = e.rows(); k-- > edge;) {
    behind += l.score[k];
    weight_behind += l.curvature[k];
    if (k + edge > e.rows()) continue;
    const double part = weight_behind / weight, information = weight_behind * (1 - part);
    const double gain = information > 0 ? std::pow(behind - part * all, 2) / information : 0;
    if (gain > best) best = gain, at = k;
  }
  if (at == 0) return std::nullopt;
  return step_term(e, 0.5 * (e.time[at] + e.time[at - 1]));
}

std::optional<Term> strongest_order(const Evidence& e, const Explanation& model) {
  if (e.rests()) return std::nullopt;
  // Up to a period of four counts.
  // What was not seen once and a half is no period.
  const double range = e.path.maxCoeff() - e.path.minCoeff();
  const double least = range > 0 ? 3 * std::numbers::pi / range : 0;
  const double order = strongest_rate(model.plain().score, e.path, least, 0.5 * std::numbers::pi / e.step());
  if (order == 0) return std::nullopt;
  return free_order_term(e, order);
}

std::optional<Term> strongest_vibration(const Evidence& e, const Explanation& model) {
  if (!e.ordered) return std::nullopt;
  const double duration = e.time[e.rows() - 1];
  const double interval = duration / static_cast<double>(e.rows());
  const double rate = strongest_rate(model.plain().score, e.time, 2 * std::numbers::pi * 4 / duration,
                                     std::numbers::pi / interval);
  if (rate == 0) return std::nullopt;
  return vibration_term(e, rate / (2 * std::numbers::pi));
}

std::vector<Term> at_whole_orders(const Evidence& e, const Term& t) {
  std::vector<Term> whole;
  const double ratio = std::abs(e.encoder.shaft_ratio);
  for (const bool of_encoder : {true, false}) {
    if (e.prismatic && !of_encoder) continue;
    const double order = t.shape / (of_encoder ? ratio : 1), nearest = std::round(order);
    if (nearest < 1 || std::abs(order - nearest) * (of_encoder ? ratio : 1) > t.reach) continue;
    whole.push_back(
        periodic_term(e, nearest == 1 ? "eccentricity" : "transmission_error", nearest, of_encoder));
  }
  return whole;
}

}  // namespace qerr
