#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/statistics.hpp"
#include "design/encoder_choice.hpp"

namespace qerr {
std::vector<std::size_t> option_offsets(const ChoiceProblem& problem) {
  std::vector<std::size_t> offsets{0};
  for (const auto& prices : problem.prices) offsets.push_back(offsets.back() + prices.size());
  return offsets;
}

std::int64_t price_of(const ChoiceProblem& problem, const OptionChoice& choice) {
  std::int64_t sum = 0;
  for (std::size_t j = 0; j < choice.size(); ++j) sum += problem.prices[j][choice[j]];
  return sum;
}

SumWeights weights_of(const ChoiceFigure& figure, const OptionChoice& choice) {
  SumWeights weights;
  for (const WeightedSum& sum : figure.sums) {
    auto& of_sum = weights.emplace_back();
    for (const WeightedColumn& c : sum.columns) of_sum.push_back(c.weights[choice[c.joint]]);
  }
  return weights;
}

SumWeights least_weights(const ChoiceFigure& figure, const std::vector<std::size_t>& offsets,
                         const std::vector<char>& permitted) {
  SumWeights weights;
  for (const WeightedSum& sum : figure.sums) {
    auto& of_sum = weights.emplace_back();
    for (const WeightedColumn& c : sum.columns) {
      double least = std::numeric_limits<double>::infinity();
      for (std::size_t o = 0; o < c.weights.size(); ++o)
        if (permitted[offsets[c.joint] + o]) least = std::min(least, c.weights[o]);
      of_sum.push_back(least);
    }
  }
  return weights;
}

namespace {

/// Configurations that are evaluated together: their sums stay in the first cache.
constexpr std::size_t block_size = 1024;
using Block = Eigen::Array<double, block_size, 1>;

/// The largest of the sums at configurations first .. first + count - 1, before the root.
void evaluate_block(const ChoiceFigure& figure, const SumWeights& weights, std::size_t first,
                    std::size_t count, Block& to) {
  Block other;
  for (std::size_t s = 0; s < figure.sums.size(); ++s) {
    Block& sum = s == 0 ? to : other;
    const auto n = static_cast<Eigen::Index>(count);
    sum.head(n).setConstant(figure.sums[s].added);
    for (std::size_t k = 0; k < weights[s].size(); ++k)
      if (weights[s][k] != 0)
        sum.head(n) += weights[s][k] *
                       Eigen::Map<const Eigen::ArrayXd>(figure.sums[s].columns[k].coefficients + first, n);
    if (s > 0) to.head(n) = to.head(n).max(other.head(n));
  }
}

/// Calls use(first, count, values) for blocks of configurations until it returns false. Begins at the block
/// of `start` and wraps around.
template <class Use>
void for_blocks(const ChoiceFigure& figure, const SumWeights& weights, std::size_t configurations,
                std::size_t start, Use use) {
  Block values;
  const std::size_t blocks = (configurations + block_size - 1) / block_size;
  for (std::size_t b = 0; b < blocks; ++b) {
    const std::size_t first = (start / block_size + b) % blocks * block_size;
    const std::size_t count = std::min(block_size, configurations - first);
    evaluate_block(figure, weights, first, count, values);
    if (!use(first, count, values)) return;
  }
}

double interpolated(std::vector<double>& values, double fraction) {
  const PercentileRank rank(fraction, values.size());
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank.below);
  std::nth_element(values.begin(), at, values.end());
  const double low = *at;
  if (rank.part == 0) return low;
  const double high = *std::min_element(at + 1, values.end());
  return low + rank.part * (high - low);
}

LimitTest largest_test(const ChoiceFigure& figure, const SumWeights& weights, double limit,
                       std::size_t configurations, std::size_t start) {
  LimitTest test;
  for_blocks(figure, weights, configurations, start,
             [&](std::size_t first, std::size_t count, const Block& v) {
               Eigen::Index at = 0;
               if (!(v.head(count).maxCoeff(&at) > limit)) return true;
               test.met = false;
               test.worst = first + static_cast<std::size_t>(at);
               return false;
             });
  return test;
}

/// Of the configurations beyond the limit those that exceed it most are kept: a few more than are permitted,
/// so that neighbouring choices fail by them, too.
void keep_most_excessive(std::vector<std::pair<double, std::uint32_t>>& beyond, std::size_t permitted,
                         std::vector<std::uint32_t>& kept) {
  const std::size_t count = std::min(beyond.size(), permitted + permitted / 2 + 8);
  std::nth_element(beyond.begin(), beyond.begin() + (count - 1), beyond.end(),
                   [](const auto& a, const auto& b) { return a > b; });
  for (std::size_t i = 0; i < count; ++i) kept.push_back(beyond[i].second);
  std::ranges::sort(kept);
}

LimitTest percentile_test(const ChoiceFigure& figure, const SumWeights& weights, double limit,
                          std::size_t configurations) {
  const PercentileRank rank(figure.percentile, configurations);
  const std::size_t permitted = rank.permitted(configurations);
  std::vector<std::pair<double, std::uint32_t>> beyond;
  double low = -std::numeric_limits<double>::infinity();
  for_blocks(figure, weights, configurations, 0, [&](std::size_t first, std::size_t count, const Block& v) {
    for (std::size_t i = 0; i < count; ++i) {
      const double value = v[i];
      if (value > limit)
        beyond.emplace_back(value, static_cast<std::uint32_t>(first + i));
      else
        low = std::max(low, value);
    }
    return true;
  });
  LimitTest test;
  test.met = beyond.size() < permitted || (beyond.size() == permitted && rank.part == 0);
  if (beyond.size() == permitted && rank.part > 0) {  // the limit lies between both order statistics
    const double high = std::ranges::min_element(beyond)->first;
    const auto value = [&](double v) { return figure.root ? std::sqrt(v) : v; };
    test.met = value(low) + rank.part * (value(high) - value(low)) <= value(limit);
  }
  if (!test.met) {
    const auto at = beyond.begin() + static_cast<std::ptrdiff_t>(std::min(permitted, beyond.size() - 1));
    std::nth_element(beyond.begin(), at, beyond.end(), [](const auto& a, const auto& b) { return a > b; });
    test.worst = at->second;
    keep_most_excessive(beyond, permitted, test.beyond);
  }
  return test;
}

double mean_of(const ChoiceFigure& figure, const SumWeights& weights, std::size_t configurations) {
  long double sum = 0;
  for_blocks(figure, weights, configurations, 0, [&](std::size_t, std::size_t count, const Block& v) {
    const auto n = static_cast<Eigen::Index>(count);
    sum += figure.root ? v.head(n).sqrt().sum() : v.head(n).sum();
    return true;
  });
  return static_cast<double>(sum / static_cast<long double>(configurations));
}

/// The largest of the sums at a configuration, and its value.
std::pair<std::size_t, double> largest_sum(const ChoiceFigure& figure, const SumWeights& weights,
                                           std::size_t configuration) {
  std::pair<std::size_t, double> largest{0, 0};
  for (std::size_t s = 0; s < figure.sums.size(); ++s) {
    double sum = figure.sums[s].added;
    for (std::size_t k = 0; k < weights[s].size(); ++k)
      sum += weights[s][k] * figure.sums[s].columns[k].coefficients[configuration];
    if (s == 0 || sum > largest.second) largest = {s, sum};
  }
  return largest;
}

void add_part(ChoiceCut& cut, const std::vector<std::size_t>& offsets, const WeightedColumn& column,
              double coefficient, bool of_sigma) {
  for (std::size_t o = 0; o < column.weights.size(); ++o)
    cut.parts[offsets[column.joint] + o] +=
        coefficient * (of_sigma ? std::sqrt(column.weights[o]) : column.weights[o]);
}

}  // namespace

double figure_value(const ChoiceFigure& figure, const SumWeights& weights, std::size_t configurations) {
  if (figure.over == ChoiceFigure::Over::mean) return mean_of(figure, weights, configurations);
  std::vector<double> values;
  values.reserve(configurations);
  for_blocks(figure, weights, configurations, 0, [&](std::size_t, std::size_t count, const Block& v) {
    values.insert(values.end(), v.data(), v.data() + count);
    return true;
  });
  if (figure.root)
    for (double& v : values) v = std::sqrt(v);
  return figure.over == ChoiceFigure::Over::percentile ? interpolated(values, figure.percentile)
         : figure.over == ChoiceFigure::Over::least    ? *std::ranges::min_element(values)
                                                       : *std::ranges::max_element(values);
}

LimitTest compare_with_limit(const ChoiceFigure& figure, const SumWeights& weights, double limit,
                             std::size_t configurations, std::size_t first) {
  if (limit == std::numeric_limits<double>::infinity()) return {};
  const double of_sums = figure.root ? limit * limit : limit;
  switch (figure.over) {
    case ChoiceFigure::Over::largest:
      return largest_test(figure, weights, of_sums, configurations, first);
    case ChoiceFigure::Over::percentile:
      return percentile_test(figure, weights, of_sums, configurations);
    case ChoiceFigure::Over::mean:
    case ChoiceFigure::Over::least:
      break;
  }
  LimitTest test;
  test.met = figure_value(figure, weights, configurations) <= limit;
  return test;
}

ChoiceCut tangent_of_mean(const ChoiceFigure& figure, std::size_t index, const ChoiceProblem& problem,
                          const SumWeights& weights) {
  const std::vector<std::size_t> offsets = option_offsets(problem);
  ChoiceCut cut{index, std::vector<double>(offsets.back()), 0, false};
  std::vector<std::vector<double>> gradients;
  for (const auto& of_sum : weights) gradients.emplace_back(of_sum.size());
  std::vector<double> of_added(figure.sums.size());
  const double part = 1 / static_cast<double>(problem.configurations);
  for (std::size_t i = 0; i < problem.configurations; ++i) {
    const auto [largest, value] = largest_sum(figure, weights, i);
    if (figure.root && !(value > 0)) continue;
    const double slope = figure.root ? part / std::sqrt(value) : part;
    of_added[largest] += slope;
    for (std::size_t k = 0; k < weights[largest].size(); ++k)
      gradients[largest][k] += slope * figure.sums[largest].columns[k].coefficients[i];
  }
  for (std::size_t s = 0; s < figure.sums.size(); ++s) {
    // sqrt(sum c s^2) has the tangent sum (c s0/value) s; the added variance is a sigma of its own.
    cut.constant += of_added[s] * figure.sums[s].added;
    for (std::size_t k = 0; k < weights[s].size(); ++k)
      add_part(cut, offsets, figure.sums[s].columns[k],
               gradients[s][k] * (figure.root ? std::sqrt(weights[s][k]) : 1), figure.root);
  }
  return cut;
}

ChoiceCut cut_at_configuration(const ChoiceFigure& figure, std::size_t index, const ChoiceProblem& problem,
                               const SumWeights& weights, std::size_t configuration) {
  const std::vector<std::size_t> offsets = option_offsets(problem);
  const std::size_t largest = largest_sum(figure, weights, configuration).first;
  ChoiceCut cut{index, std::vector<double>(offsets.back()), figure.sums[largest].added, figure.root};
  for (const WeightedColumn& column : figure.sums[largest].columns)
    add_part(cut, offsets, column, column.coefficients[configuration], false);
  return cut;
}

}  // namespace qerr
