#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/statistics.hpp"
#include "design/encoder_choice.hpp"

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
  std::ranges::fill(multipliers_, 0);
  std::ranges::fill(reduction_, 0);
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
    std::ranges::fill(reduction, 0);
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
  std::ranges::fill(reduction_, 0);
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

struct FailureSample::Values {
  std::vector<Eigen::ArrayXd> sums;
};

FailureSample::FailureSample(const ChoiceFigure& figure, std::size_t configurations)
    : figure_(&figure),
      permitted_(PercentileRank(figure.percentile, configurations).permitted(configurations)) {
  for (const WeightedSum& sum : figure.sums) columns_.emplace_back(sum.columns.size());
}

void FailureSample::add(const std::vector<std::uint32_t>& configurations) {
  std::vector<std::uint32_t> all;
  std::set_union(members_.begin(), members_.end(), configurations.begin(), configurations.end(),
                 std::back_inserter(all));
  if (all.size() == members_.size()) return;
  members_ = std::move(all);
  for (std::size_t s = 0; s < columns_.size(); ++s)
    for (std::size_t k = 0; k < columns_[s].size(); ++k) {
      columns_[s][k].clear();
      const double* const from = figure_->sums[s].columns[k].coefficients;
      for (const std::uint32_t i : members_) columns_[s][k].push_back(from[i]);
    }
}

bool FailureSample::fails(const Values& values, double limit) const {
  Eigen::ArrayXd largest = values.sums.front();
  for (std::size_t s = 1; s < values.sums.size(); ++s) largest = largest.max(values.sums[s]);
  return static_cast<std::size_t>((largest > limit).count()) > permitted_;
}

void FailureSample::restrict_joint(std::size_t joint, const Values& least, const SumWeights& weights,
                                   double limit, const std::vector<std::size_t>& offsets,
                                   PermittedOptions& permitted, double& work) const {
  std::vector<std::size_t> options;
  const WeightedColumn* only = nullptr;
  std::size_t columns = 0;
  for (const WeightedSum& sum : figure_->sums)
    for (const WeightedColumn& c : sum.columns)
      if (c.joint == joint) {
        only = &c;
        ++columns;
      }
  for (std::size_t o = offsets[joint]; o < offsets[joint + 1]; ++o)
    if (permitted[o]) options.push_back(o - offsets[joint]);
  if (!only || options.size() < 2) return;
  const auto fails_with = [&](std::size_t option) {
    Values values = least;
    for (std::size_t s = 0; s < columns_.size(); ++s)
      for (std::size_t k = 0; k < columns_[s].size(); ++k) {
        const WeightedColumn& c = figure_->sums[s].columns[k];
        const double more = c.joint == joint ? c.weights[option] - weights[s][k] : 0;
        if (more == 0) continue;
        values.sums[s] += more * Eigen::Map<const Eigen::ArrayXd>(columns_[s][k].data(), size());
      }
    work += 3 * static_cast<double>(size() * columns);
    return fails(values, limit);
  };
  if (columns > 1) {
    for (const std::size_t o : options)
      if (fails_with(o)) permitted[offsets[joint] + o] = 0;
    return;
  }
  // With one column, options that are coarser than one that fails fail as well.
  std::ranges::sort(options,
                    [&](std::size_t a, std::size_t b) { return only->weights[a] > only->weights[b]; });
  if (!fails_with(options.front())) return;
  const auto first_good = std::partition_point(options.begin() + 1, options.end(), fails_with);
  for (auto o = options.begin(); o != first_good; ++o) permitted[offsets[joint] + *o] = 0;
}

bool FailureSample::restrict(double limit, const std::vector<std::size_t>& offsets,
                             PermittedOptions& permitted, double& work) const {
  if (size() <= permitted_ || !(limit < std::numeric_limits<double>::infinity())) return true;
  limit *= 1 + 2 * figure_->tolerance;
  if (figure_->root) limit *= limit;
  const SumWeights weights = least_weights(*figure_, offsets, permitted);
  Values least;
  for (std::size_t s = 0; s < columns_.size(); ++s) {
    Eigen::ArrayXd& sum = least.sums.emplace_back(Eigen::ArrayXd::Constant(size(), figure_->sums[s].added));
    for (std::size_t k = 0; k < columns_[s].size(); ++k)
      if (weights[s][k] != 0)
        sum += weights[s][k] * Eigen::Map<const Eigen::ArrayXd>(columns_[s][k].data(), size());
    work += static_cast<double>(size() * columns_[s].size());
  }
  if (fails(least, limit)) return false;
  for (std::size_t j = 0; j + 1 < offsets.size(); ++j)
    restrict_joint(j, least, weights, limit, offsets, permitted, work);
  return true;
}

}  // namespace qerr
