#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/solve.hpp"
#include "core/text.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"

/// What counts alone show, without anything to compare them with: a joint has inertia, so that its speed
/// changes little from row to row, and what repeats with the shaft at a constant speed is of the shaft.
namespace qerr::sanity {

namespace {

constexpr Eigen::Index fewest_rows_alone = 200;

/// Counts of one encoder, and their steps from row to row.
struct CountsAlone {
  const Eigen::ArrayXd& counts;
  Eigen::ArrayXd steps;
  double usual;  ///< median size of a step

  explicit CountsAlone(const Eigen::ArrayXd& c)
      : counts(c), steps(c.tail(c.size() - 1) - c.head(c.size() - 1)) {
    const Eigen::ArrayXd sizes = steps.abs();
    usual = median({sizes.begin(), sizes.end()});
  }
  /// A step between rows k and k + 1 that inertia does not permit, by the steps before and behind it [counts]
  /// (convention).
  double far(Eigen::Index k) const {
    return 20 + 8 * std::max({usual, std::abs(pace(k - 5)), std::abs(pace(k + 2))});
  }
  /// Median step of the five rows before row k, or from it on.
  double pace(Eigen::Index first) const {
    const Eigen::Index from = std::clamp<Eigen::Index>(first, 0, steps.size() - 5);
    const Eigen::ArrayXd some = steps.segment(from, 5);
    return median({some.begin(), some.end()});
  }
};

void report(Sanity& s, std::size_t encoder, Eigen::Index row, DataKind kind, std::string what,
            std::string remedy) {
  s.data.push_back({std::move(what), s.model.chain.independent[encoder].name, s.log.row_number(row) + 1,
                    time_of(s, row), std::move(remedy), kind});
}

/// Readings far from both neighbours, and steps from which the counter does not return.
void find_leaps(Sanity& s, std::size_t encoder, const CountsAlone& c) {
  std::vector<Eigen::Index> single, lasting;
  double farthest = 0, leap = 0;
  for (Eigen::Index k = 5; k + 6 < c.steps.size(); ++k) {
    if (std::abs(c.steps[k]) < 20 + 8 * c.usual || std::abs(c.steps[k]) < c.far(k)) continue;
    const double back = c.counts[k + 2] - c.counts[k];
    if (std::abs(back - 2 * c.pace(k - 5)) < 0.3 * std::abs(c.steps[k]) + 2 * c.usual) {
      single.push_back(k + 1);
      farthest = std::max(farthest, std::abs(c.steps[k]));
      ++k;
      continue;
    }
    // The pace is the same before and behind it, and the joint did not rest before: a hold ends with a leap,
    // too.
    const double before = c.pace(k - 5), behind = c.pace(k + 1);
    const bool held = c.steps.segment(k - 5, 5).isZero() && !c.steps.segment(k + 1, 5).isZero();
    if (!held && std::abs(before - behind) <= 2 + 0.5 * c.usual) {
      if (lasting.empty()) leap = c.steps[k] - before;
      lasting.push_back(k + 1);
    }
  }
  if (!single.empty())
    report(s, encoder, single.front(), DataKind::corrupt,
           counted(single.size(), "single reading") + " far from both neighbours, by up to " +
               significant(farthest, 3) + " counts: no motion",
           "inspect the encoder's cable, its shielding, and whether the driver marks readings as invalid");
  if (!lasting.empty())
    report(s, encoder, lasting.front(), DataKind::corrupt,
           "the counter leaps by " + significant(leap, 4) +
               " counts while the joint moves on at the same speed" +
               (lasting.size() > 1 ? ", and " + counted(lasting.size() - 1, "more time") : ""),
           "look for counts that were set, lost, or wrapped: the index pulse shows by how much");
}

/// Values that stand while the joint moves on, now and then or from row to row.
/// @returns whether they do in most rows: then they end with leaps
bool find_holds(Sanity& s, std::size_t encoder, const CountsAlone& c) {
  Eigen::Index moving = 0, standing = 0, longest = 0, at = 0, holds = 0;
  for (Eigen::Index k = 0; k + 20 < c.steps.size(); k += 20) {
    const auto part = c.steps.segment(k, 20);
    if (std::abs(part.sum()) < 60 || part.abs().sum() > 1.2 * std::abs(part.sum())) continue;
    moving += 20;
    standing += (part == 0).count();
  }
  if (moving >= fewest_rows_alone && 3 * standing > moving) {
    const double rows = static_cast<double>(moving) / static_cast<double>(moving - standing);
    report(s, encoder, 0, DataKind::repeated,
           "counts are held for about " + significant(rows, 2) +
               " rows while the joint moves: the bus, or the logger, is "
               "slower than the log",
           "log each reading once, with its own stamp: a held one is up to " + significant(rows, 2) +
               " rows late");
    return true;
  }
  for (Eigen::Index k = 10, first = 0; k + 12 < c.steps.size(); ++k) {
    if (c.steps[k] != 0) {
      const Eigen::Index rows = k - first;
      // What it leaps by at the end is what the joint has moved meanwhile, by the pace on both sides.
      const double pace = 0.5 * (c.pace(first - 5) + c.pace(k + 1)),
                   expected = pace * static_cast<double>(rows + 1);
      if (rows >= 5 && std::abs(pace) >= 1 && std::abs(c.steps[k]) > 0.3 * std::abs(expected) &&
          std::abs(c.steps[k]) < 3 * std::abs(expected) &&
          std::abs(c.steps[k]) >= 5 * std::abs(c.pace(k + 1))) {
        ++holds;
        if (rows > longest) longest = rows, at = first;
      }
      first = k + 1;
    }
  }
  if (holds > 0)
    report(s, encoder, at, DataKind::repeated,
           "counts stand for " + std::to_string(longest) +
               " rows and then leap to where the joint has moved" +
               (holds > 1 ? ", and " + counted(static_cast<std::size_t>(holds - 1), "more time") : ""),
           "look for a reader that pauses, or a bus that repeats its last telegram");
  return false;
}

/// The longest stretch of a constant speed: rows [first, end).
std::pair<Eigen::Index, Eigen::Index> steady_stretch(const CountsAlone& c) {
  const Eigen::Index width = std::max<Eigen::Index>(20, c.counts.size() / 50);
  std::pair<Eigen::Index, Eigen::Index> best{0, 0};
  Eigen::Index first = 0;
  double pace = 0;
  for (Eigen::Index k = 0; k + width < c.counts.size(); k += width) {
    const double now = c.counts[k + width] - c.counts[k];
    if (k == first) pace = now;
    if (std::abs(now - pace) > 0.1 * std::abs(pace) + 4) {
      first = k + width;
      continue;
    }
    if (k + width - first > best.second - best.first) best = {first, k + width};
  }
  return best;
}

/// Orders of the shaft at a constant speed.
void find_ripple(Sanity& s, std::size_t encoder, const CountsAlone& c) {
  const Encoder& e = s.model.transmission.encoders[encoder];
  const double turn = 2 * std::numbers::pi / (e.resolution * std::abs(e.shaft_ratio));  // [counts]
  const auto [first, end] = steady_stretch(c);
  const Eigen::Index n = end - first;
  if (!s.log.has_time() || n < fewest_rows_alone) return;
  const Eigen::ArrayXd part = c.counts.segment(first, n);
  const double turns = std::abs(part[n - 1] - part[0]) / turn;
  if (turns < 2) return;
  const auto time = s.log.values.col(*s.log.find(LogSignal::time)).segment(first, n);
  Eigen::MatrixXd line(n, 2);
  line << Eigen::VectorXd::Ones(n), (time - time.mean()).matrix();
  const Eigen::VectorXd fit = least_norm_solution(line, part.matrix());
  const Eigen::ArrayXd path = (line * fit).array(), left = part - path;
  std::vector<std::pair<double, int>> orders;  // amplitude [counts], order
  constexpr int highest = 100;
  const double rows_per_turn = static_cast<double>(n) / turns;
  for (int k = 1; k <= highest && k < rows_per_turn / 4; ++k) {
    const Eigen::ArrayXd angle = 2 * std::numbers::pi * k * path / turn;
    const double a = 2 * (left * angle.cos()).mean(), b = 2 * (left * angle.sin()).mean();
    orders.emplace_back(std::hypot(a, b), k);
  }
  std::sort(orders.rbegin(), orders.rend());
  std::string found;
  // Beside rounding, 0.29 counts, an order of chance has sqrt(4/n) of the rms.
  const double least =
      std::max(1.0, 8 * std::sqrt(4.0 / static_cast<double>(n)) * std::sqrt(left.square().mean()));
  for (std::size_t i = 0; i < std::min<std::size_t>(3, orders.size()); ++i)
    if (orders[i].first >= std::max(least, 0.1 * orders[0].first))
      found += (found.empty() ? "" : ", ") + significant(orders[i].first, 3) + " counts at order " +
               std::to_string(orders[i].second);
  if (found.empty()) return;
  report(s, encoder, first, DataKind::remark,
         "at constant speed, over " + significant(turns, 3) +
             " revolutions of the encoder's shaft, the counts ripple: " + found,
         "an error of the encoder, or of the speed itself: drive it at another speed, of which an error of "
         "the encoder is "
         "independent, or add a reference");
}

}  // namespace

void check_unreferenced(Sanity& s, std::size_t encoder) {
  const bool tracked =
      s.log.find(LogSignal::tip, 0) || s.log.find(LogSignal::tip, 1) || s.log.find(LogSignal::tip, 2);
  const auto column = s.log.find(LogSignal::counts, encoder);
  if (!column || tracked || has_reference(s, encoder) || s.log.values.rows() < fewest_rows_alone) return;
  const Eigen::ArrayXd counts = s.log.values.col(*column);
  const CountsAlone c(counts);
  if (!find_holds(s, encoder, c)) find_leaps(s, encoder, c);
  find_ripple(s, encoder, c);
}

}  // namespace qerr::sanity
