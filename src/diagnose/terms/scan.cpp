#include "diagnose/terms/scan.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "diagnose/terms/scan_kernels.hpp"
#include "diagnose/terms/unnamed_terms.hpp"
#include "lanes/aligned.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index most_rows = 8192;

/// An even part of the rows, filled up with some of no score.
AlignedNumbers part_of(const Eigen::ArrayXd& column, double shift) {
  const Eigen::Index stride = std::max<Eigen::Index>(1, column.size() / most_rows),
                     rows = column.size() / stride;
  constexpr auto together = static_cast<Eigen::Index>(scanned_together);
  AlignedNumbers part(static_cast<std::size_t>((rows + together - 1) / together * together));
  for (Eigen::Index k = 0; k < rows; ++k) part[static_cast<std::size_t>(k)] = column[k * stride] - shift;
  return part;
}

/// The rate of most power |sum of scores e^{i rate argument}|^2 among multiples of a quarter of what the
/// argument's range resolves, then finer.
double strongest_rate(const Eigen::ArrayXd& scores, const Eigen::ArrayXd& arguments, double least,
                      double most) {
  const double lowest = arguments.minCoeff(), range = arguments.maxCoeff() - lowest;
  if (!(range > 0)) return 0;
  const double spacing = 0.5 * std::numbers::pi / range;
  const double first = std::max(2.0, std::ceil(least / spacing)),
               last = std::min<double>(scanned_hypotheses - 1, std::floor(most / spacing));
  if (!(first <= last)) return 0;
  const ScanKernels& kernels = select_kernels<ScanKernels>(instruction_set());
  // Where the argument begins does not matter to the power, but to the digits of its sine.
  const AlignedNumbers score = part_of(scores, 0), argument = part_of(arguments, lowest),
                       angle = part_of(spacing * (arguments - lowest), 0);
  std::vector<double> powers(static_cast<std::size_t>(last - first) + 1);
  const AlignedNumbers room(4 * score.size() + 2 * scanned_at_once * 8);
  kernels.powers(score.data(), angle.data(), score.size(), first, powers.size(), room.data(), powers.data());
  const auto strongest = std::max_element(powers.begin(), powers.end());
  double best = *strongest, rate = (first + static_cast<double>(strongest - powers.begin())) * spacing;
  for (double step = spacing / 2; step > spacing / 200; step /= 2)
    for (const double here : {rate - step, rate + step})
      if (const double p = kernels.power(score.data(), argument.data(), score.size(), here); p > best)
        best = p, rate = here;
  return best > 0 ? rate : 0;
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
  if (e.is_stationary()) return std::nullopt;
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
    if (nearest < 1 || std::abs(order - nearest) * (of_encoder ? ratio : 1) > t.half_width) continue;
    whole.push_back(periodic_term(e, nearest, of_encoder));
  }
  return whole;
}

}  // namespace qerr
