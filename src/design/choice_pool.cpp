#include "design/choice_pool.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace qerr {

CutPool::CutPool(const ChoiceProblem& problem)
    : offsets_(option_offsets(problem)), reduction_(offsets_.back()) {
  step_ = 0;
  for (const auto& prices : problem.prices) {
    base_ += prices.front();
    for (const std::int64_t p : prices) {
      price_.push_back(static_cast<double>(p));
      step_ = std::gcd(step_, p - prices.front());
    }
  }
  step_ = std::max<std::int64_t>(step_, 1);
  for (const ChoiceFigure& f : problem.figures) tolerances_.push_back(f.tolerance);
}

void CutPool::set_room(Row& row) const {
  // Twice the tolerance within which the choice itself is judged by `judge`.
  const double limit = limits_[row.cut.figure] * (1 + 2 * tolerances_[row.cut.figure]);
  row.room = (row.cut.squared ? limit * limit : limit) - row.cut.constant;
  row.scale = 0;
  for (const double part : row.cut.parts) row.scale = std::max(row.scale, std::abs(part));
  row.scale = std::isfinite(row.room) ? std::max(std::abs(row.room), 1e-12 * row.scale) : row.scale;
  if (!(row.scale > 0)) row.scale = 1;
}

void CutPool::add(ChoiceCut cut, bool guide) {
  cuts_.push_back({std::move(cut), guide, 0, 1});
  set_room(cuts_.back());
  multipliers_.push_back(0);
}

void CutPool::begin(const std::vector<double>& limits, const PermittedOptions& permitted) {
  limits_ = limits;
  options_.assign(offsets_.size() - 1, {});
  count_ = 0;
  for (std::size_t j = 0; j < options_.size(); ++j)
    for (std::size_t o = offsets_[j]; o < offsets_[j + 1]; ++o)
      if (permitted[o]) {
        options_[j].push_back(o);
        ++count_;
      }
  for (Row& row : cuts_) set_room(row);
  std::fill(multipliers_.begin(), multipliers_.end(), 0);
  std::fill(reduction_.begin(), reduction_.end(), 0);
  reduction_of_rooms_ = 0;
}

namespace {

/// The least of the permitted values of each joint; infinite where none is permitted.
template <class Value>
void least_per_joint(const std::vector<std::vector<std::size_t>>& options, const PermittedOptions& permitted,
                     Value value, std::vector<double>& least) {
  least.assign(options.size(), std::numeric_limits<double>::infinity());
  for (std::size_t j = 0; j < options.size(); ++j)
    for (const std::size_t o : options[j])
      if (permitted[o]) least[j] = std::min(least[j], value(o));
}

double sum_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

/// Part of a cut's scale that rounding of its sums may be.
constexpr double rounding_of_cuts = 1e-12;

}  // namespace

bool CutPool::remove_by_cuts(PermittedOptions& permitted, bool& changed, double& work) const {
  std::vector<double> least;
  for (const Row& row : cuts_) {
    if (row.guide || !std::isfinite(row.room)) continue;
    least_per_joint(
        options_, permitted, [&](std::size_t o) { return row.cut.parts[o]; }, least);
    const double slack = row.room - sum_of(least) + rounding_of_cuts * row.scale;
    if (!(slack >= 0)) return false;
    for (std::size_t j = 0; j < least.size(); ++j)
      for (const std::size_t o : options_[j])
        if (permitted[o] && row.cut.parts[o] - least[j] > slack) {
          permitted[o] = 0;
          changed = true;
        }
  }
  work += 2 * static_cast<double>(cuts_.size() * count_);
  return true;
}

std::int64_t CutPool::rounded_up(double bound) const {
  // Prices of choices are base + k step.
  const double steps = (bound - static_cast<double>(base_)) / static_cast<double>(step_);
  const double rounding = 1e-6 + 1e-12 * std::abs(bound) / static_cast<double>(step_);
  return base_ + step_ * static_cast<std::int64_t>(std::ceil(std::min(steps - rounding, 9e15)));
}

bool CutPool::remove_by_price(PermittedOptions& permitted, std::int64_t most, std::int64_t& bound,
                              bool& changed) const {
  std::vector<double> least;
  bound = std::numeric_limits<std::int64_t>::min();
  for (const bool with_multipliers : {false, true}) {
    const auto value = [&](std::size_t o) { return with_multipliers ? reduced(o) : price_[o]; };
    least_per_joint(options_, permitted, value, least);
    const double sum = sum_of(least) - (with_multipliers ? reduction_of_rooms_ : 0);
    if (!(sum < std::numeric_limits<double>::infinity())) return false;
    bound = std::max(bound, rounded_up(sum));
    if (bound > most) return false;
    for (std::size_t j = 0; j < least.size(); ++j)
      for (const std::size_t o : options_[j])
        if (permitted[o] && rounded_up(sum - least[j] + value(o)) > most) {
          permitted[o] = 0;
          changed = true;
        }
  }
  return true;
}

bool CutPool::restrict(PermittedOptions& permitted, std::int64_t most, std::int64_t& bound,
                       double& work) const {
  constexpr int most_rounds = 4;  // each is valid by itself
  for (int round = 0; round < most_rounds; ++round) {
    bool changed = false;
    if (!remove_by_price(permitted, most, bound, changed)) return false;
    if (!remove_by_cuts(permitted, changed, work)) return false;
    work += 4 * static_cast<double>(count_);
    if (!changed) return true;
  }
  bool changed = false;
  return remove_by_price(permitted, most, bound, changed);
}

void CutPool::improve_multipliers(const PermittedOptions& permitted, std::optional<std::int64_t> target,
                                  double& work) {
  constexpr int iterations = 150;
  std::vector<double> current = multipliers_, best = multipliers_, reduction(reduction_.size()), gradient;
  double best_bound = -std::numeric_limits<double>::infinity(), step_part = 1;
  int since_best = 0;
  for (int i = 0; i < iterations; ++i) {
    std::fill(reduction.begin(), reduction.end(), 0);
    double rooms = 0;
    for (std::size_t r = 0; r < cuts_.size(); ++r) {
      if (current[r] == 0) continue;
      for (const auto& of_joint : options_)
        for (const std::size_t o : of_joint)
          reduction[o] += current[r] / cuts_[r].scale * cuts_[r].cut.parts[o];
      rooms += current[r] / cuts_[r].scale * cuts_[r].room;
    }
    double bound = -rooms;
    std::vector<std::size_t> at(offsets_.size() - 1);
    for (std::size_t j = 0; j < at.size(); ++j) {
      double least = std::numeric_limits<double>::infinity();
      for (const std::size_t o : options_[j])
        if (permitted[o] && price_[o] + reduction[o] < least) {
          least = price_[o] + reduction[o];
          at[j] = o;
        }
      bound += least;
    }
    work += 2 * static_cast<double>(cuts_.size() * count_);
    if (bound > best_bound) {
      best_bound = bound;
      best = current;
      since_best = 0;
    } else if (++since_best == 10) {
      step_part /= 2;
      since_best = 0;
      current = best;
      continue;
    }
    gradient.assign(cuts_.size(), 0);
    double square = 0;
    for (std::size_t r = 0; r < cuts_.size(); ++r) {
      if (cuts_[r].guide || !std::isfinite(cuts_[r].room)) continue;
      double excess = -cuts_[r].room;
      for (const std::size_t o : at) excess += cuts_[r].cut.parts[o];
      excess /= cuts_[r].scale;
      if (excess > 0 || current[r] > 0) gradient[r] = excess;
      square += gradient[r] * gradient[r];
    }
    if (!(square > 0)) break;
    const double aim = target ? static_cast<double>(*target)
                              : best_bound + 0.05 * std::abs(best_bound) + static_cast<double>(step_);
    const double step = step_part * std::max(aim - bound, static_cast<double>(step_)) / square;
    for (std::size_t r = 0; r < cuts_.size(); ++r)
      current[r] = std::max(0.0, current[r] + step * gradient[r]);
  }
  multipliers_ = best;
  std::fill(reduction_.begin(), reduction_.end(), 0);
  reduction_of_rooms_ = 0;
  for (std::size_t r = 0; r < cuts_.size(); ++r) {
    if (multipliers_[r] == 0) continue;
    for (std::size_t o = 0; o < reduction_.size(); ++o)
      reduction_[o] += multipliers_[r] / cuts_[r].scale * cuts_[r].cut.parts[o];
    reduction_of_rooms_ += multipliers_[r] / cuts_[r].scale * cuts_[r].room;
  }
}

double CutPool::usage(const OptionChoice& choice) const {
  double largest = 0;
  for (const Row& row : cuts_) {
    if (!std::isfinite(row.room)) continue;
    double sum = 0;
    for (std::size_t j = 0; j < choice.size(); ++j) sum += row.cut.parts[offsets_[j] + choice[j]];
    largest = std::max(largest, row.room > 0     ? sum / row.room
                                : sum > row.room ? std::numeric_limits<double>::infinity()
                                                 : 0);
  }
  return largest;
}

}  // namespace qerr
