#include "diagnose/search/residual_scan.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "diagnose/search/peaks.hpp"
#include "diagnose/search/unnamed_terms.hpp"

namespace qerr {

namespace {

constexpr double turn = 2 * std::numbers::pi;
constexpr int most_events = 4;

bool has_near(const std::vector<Scanned::Rate>& rates, double value, double within) {
  // Between two whole orders that are chosen there may be the one order that they imitate.
  return std::any_of(rates.begin(), rates.end(), [&](const Scanned::Rate& r) {
    return std::abs(r.value - value) < (r.whole ? 0.4 : 1) * within;
  });
}

/// Decrease of the weighted sum of squares by a term alone.
double gain_of(const Term& t, const Eigen::ArrayXd& scores, const Eigen::ArrayXd& weight) {
  double gain = 0;
  for (Eigen::Index i = 0; i < t.size(); ++i) {
    const auto column = t.columns.col(i);
    gain += std::pow((column * scores).sum(), 2) / std::max((column.square() * weight).sum(), 1e-300);
  }
  return gain;
}

/// The order that the motion still resolves: a period of four counts, and two rows a period in nine tenths
/// of the motion. At a constant speed an order beyond that is the alias of another.
double highest_order(const Evidence& record) {
  const double of_counts = 0.5 * std::numbers::pi / record.step();
  if (!record.ordered || record.rows() < 3) return of_counts;
  const Eigen::Index n = record.rows() - 1, stride = std::max<Eigen::Index>(1, n / 20000);
  std::vector<double> moved;
  for (Eigen::Index k = 0; k < n; k += stride)
    if (const double by = std::abs(record.path[k + 1] - record.path[k]); by > 4 * record.path_noise)
      moved.push_back(by);
  if (moved.size() < 20) return of_counts;
  const auto tenth = moved.begin() + static_cast<std::ptrdiff_t>(moved.size() / 10);
  std::nth_element(moved.begin(), tenth, moved.end());
  const double recorded = record.interval * static_cast<double>(n) / (record.time[n] - record.time[0]);
  return std::min(of_counts, std::numbers::pi / (*tenth * recorded));
}

/// The order near one of a periodogram whose sine lowers the sum of squares most beside a constant. Where the
/// path covers few periods, a peak of the periodogram is displaced by the mean and by its own side lobes.
double refined_order(const ErrorModel& m, const Eigen::ArrayXd& residual, double order) {
  constexpr double few_periods = 8;
  const double resolution = turn / m.sampled().range();
  if (order > few_periods * resolution) return order;
  double best = m.gain(free_order_term(m.sampled(), order), residual);
  for (double step = 0.25 * resolution; step > 0.005 * resolution; step /= 2) {
    bool better = true;
    for (int move = 0; better && move < most_moves_of_step; ++move) {
      better = false;
      for (const double other : {order - step, order + step}) {
        if (other < 0.75 * resolution) continue;
        if (const double gain = m.gain(free_order_term(m.sampled(), other), residual);
            gain > best * (1 + 1e-9)) {
          best = gain, order = other, better = true;
          break;
        }
      }
    }
  }
  return order;
}

bool scan_orders(const ErrorModel& m, const Eigen::ArrayXd& residual, const Eigen::ArrayXd& scores,
                 std::vector<Scanned::Rate>& known) {
  const double range = m.sampled().range();
  const RateScan s{turn / range, highest_order(m.record()), 5};
  double hypotheses = 1;
  bool any = false;
  for (double rate : strongest_rates(scores, m.sampled().path, s, hypotheses)) {
    if (gain_of(free_order_term(m.sampled(), rate), scores, m.weight()) < 2 * std::log(hypotheses)) break;
    rate = refined_order(m, residual, rate);
    if (has_near(known, rate, 0.25 * turn / range)) continue;
    known.push_back({rate, hypotheses});
    any = true;
  }
  return any;
}

bool scan_loaded_orders(const ErrorModel& m, const Eigen::ArrayXd& scores,
                        std::vector<Scanned::Rate>& known) {
  const double range = m.sampled().range();
  const RateScan s{1.5 * turn / range, highest_order(m.record()), 2};
  const Eigen::ArrayXd load = m.sampled().effort / std::max(1e-300, m.sampled().effort.abs().maxCoeff());
  double hypotheses = 1;
  bool any = false;
  for (const double rate : strongest_rates(scores * load, m.sampled().path, s, hypotheses)) {
    if (has_near(known, rate, 0.25 * turn / range)) continue;
    known.push_back({rate, hypotheses});
    any = true;
  }
  return any;
}

bool scan_lines(const ErrorModel& m, const Eigen::ArrayXd& scores, std::vector<Scanned::Rate>& known,
                double duration) {
  const RateScan s{turn * 8 / duration, std::numbers::pi / m.sampled().interval, 3};
  double hypotheses = 1;
  bool any = false;
  for (const double rate : strongest_rates(scores, m.sampled().time, s, hypotheses)) {
    if (has_near(known, rate / turn, 0.25 / duration)) continue;
    known.push_back({rate / turn, hypotheses});
    any = true;
  }
  return any;
}

bool scan_events(const ErrorModel& m, Eigen::ArrayXd left, std::vector<Event>& known, double duration) {
  const Eigen::ArrayXd& weight = m.weight();
  bool any = false;
  for (int i = 0; i < most_events; ++i) {
    Event event = strongest_event(left, weight, m.sampled().time);
    if (event.hypotheses == 0) break;
    const Term t = offset_step_term(m.sampled(), event.time);
    const Eigen::ArrayXd step = t.columns.col(0) - (t.columns.col(0) * weight).sum() / weight.sum();
    const double size = (step * weight * left).sum() / (step.square() * weight).sum();
    if (size * size * (step.square() * weight).sum() < 2 * std::log(event.hypotheses)) break;
    if (std::none_of(known.begin(), known.end(),
                     [&](const Event& e) { return std::abs(e.time - event.time) < 2e-3 * duration; })) {
      find_transitions(event, left, weight, m.sampled().time);
      known.push_back(event);
      any = true;
    }
    left -= size * step;
  }
  return any;
}

bool scan_places(const ErrorModel& m, const Eigen::ArrayXd& residual, std::vector<Bump>& known) {
  const Bump b = strongest_bump(residual, m.weight(), m.sampled().path);
  if (b.width == 0 || std::any_of(known.begin(), known.end(),
                                  [&](const Bump& p) { return std::abs(p.position - b.position) < b.width; }))
    return false;
  known.push_back({b.position, b.width, b.hypotheses});
  return true;
}

}  // namespace

bool scan_residual(const ErrorModel& m, const Eigen::ArrayXd& residual, Scanned& scanned) {
  const Eigen::ArrayXd& weight = m.weight();
  const Eigen::ArrayXd scores = (residual - (residual * weight).sum() / weight.sum()) * weight;
  const Evidence& sampled = m.sampled();
  bool any = false;
  if (!sampled.is_stationary()) any |= scan_orders(m, residual, scores, scanned.orders);
  if (!sampled.is_stationary() && sampled.effort.size() > 0)
    any |= scan_loaded_orders(m, scores, scanned.loaded_orders);
  if (const double duration = sampled.ordered ? sampled.time[sampled.rows() - 1] : 0; duration > 0) {
    any |= scan_lines(m, scores, scanned.lines, duration);
    any |= scan_events(m, residual, scanned.events, duration);
  }
  if (!sampled.is_stationary()) any |= scan_places(m, residual, scanned.places);
  return any;
}

}  // namespace qerr
