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

/// Every n-th row, at most about `most_rows`, padded with zeros to a multiple of `scanned_together`.
AlignedNumbers decimated(const Eigen::ArrayXd& column, double shift) {
  const Eigen::Index stride = std::max<Eigen::Index>(1, column.size() / most_rows),
                     rows = column.size() / stride;
  constexpr auto together = static_cast<Eigen::Index>(scanned_together);
  AlignedNumbers out(static_cast<std::size_t>((rows + together - 1) / together * together));
  for (Eigen::Index k = 0; k < rows; ++k) out[static_cast<std::size_t>(k)] = column[k * stride] - shift;
  return out;
}

/// The rate that maximizes the periodogram |sum of scores e^{i rate argument}|^2: on a grid with a quarter of
/// the spacing 2 pi/range of independent rates, then refined by step halving. 0 if the range or the power is
/// zero.
double strongest_rate(const Eigen::ArrayXd& scores, const Eigen::ArrayXd& arguments, double least,
                      double most) {
  const double lowest = arguments.minCoeff(), range = arguments.maxCoeff() - lowest;
  if (!(range > 0)) return 0;
  const double spacing = 0.5 * std::numbers::pi / range;
  const double first = std::max(2.0, std::ceil(least / spacing)),
               last = std::min<double>(scanned_hypotheses - 1, std::floor(most / spacing));
  if (!(first <= last)) return 0;
  const ScanKernels& kernels = select_kernels<ScanKernels>(instruction_set());
  // The power does not depend on the origin of the argument; a small argument has an accurate sine.
  const AlignedNumbers score = decimated(scores, 0), argument = decimated(arguments, lowest),
                       angle = decimated(spacing * (arguments - lowest), 0);
  std::vector<double> powers(static_cast<std::size_t>(last - first) + 1);
  const AlignedNumbers scratch(4 * score.size() + 2 * scanned_at_once * 8);
  kernels.powers(score.data(), angle.data(), score.size(), first, powers.size(), scratch.data(),
                 powers.data());
  const auto strongest = std::max_element(powers.begin(), powers.end());
  double best = *strongest, rate = (first + static_cast<double>(strongest - powers.begin())) * spacing;
  for (double step = spacing / 2; step > spacing / 200; step /= 2)
    for (const double candidate : {rate - step, rate + step})
      if (const double p = kernels.power(score.data(), argument.data(), score.size(), candidate); p > best)
        best = p, rate = candidate;
  return best > 0 ? rate : 0;
}

}  // namespace

std::optional<Term> strongest_step(const Evidence& e, const Explanation& model) {
  if (!e.ordered) return std::nullopt;
  // Score of a step at k: the sum of the later scores, orthogonal to a constant.
  const IntervalLikelihood& l = model.plain();
  const double all = l.score.sum(), weight = l.curvature.sum();
  constexpr Eigen::Index edge = 8;  // least number of rows on either side of a step (convention)
  double after = 0, weight_after = 0, best = 0;
  Eigen::Index first = 0;
  for (Eigen::Index k = e.rows(); k-- > edge;) {
    after += l.score[k];
    weight_after += l.curvature[k];
    if (k + edge > e.rows()) continue;
    const double part = weight_after / weight, information = weight_after * (1 - part);
    const double gain = information > 0 ? std::pow(after - part * all, 2) / information : 0;
    if (gain > best) best = gain, first = k;
  }
  if (first == 0) return std::nullopt;
  return step_term(e, 0.5 * (e.time[first] + e.time[first - 1]));
}

std::optional<Term> strongest_order(const Evidence& e, const Explanation& model) {
  if (e.is_stationary()) return std::nullopt;
  // From 1.5 periods within the range (convention) to a period of four counts.
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
  std::vector<Term> integer;
  const double ratio = std::abs(e.encoder.shaft_ratio);
  for (const bool of_encoder : {true, false}) {
    if (e.prismatic && !of_encoder) continue;
    const double order = t.shape / (of_encoder ? ratio : 1), nearest = std::round(order);
    if (nearest < 1 || std::abs(order - nearest) * (of_encoder ? ratio : 1) > t.half_width) continue;
    integer.push_back(periodic_term(e, nearest, of_encoder));
  }
  return integer;
}

}  // namespace qerr
