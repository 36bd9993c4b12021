#include "bound/column_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "bound/form_statistics.hpp"
#include "bound/joined_tally.hpp"
#include "core/parallel.hpp"
#include "core/random.hpp"
#include "lanes/batch.hpp"

namespace qerr {

namespace {

/// Places in random order: what comes first is a sample, also of a grid or of Sobol's sequence.
std::vector<std::int32_t> shuffled(std::size_t count) {
  std::vector<std::int32_t> order(count);
  std::iota(order.begin(), order.end(), 0);
  for (std::size_t i = count; i > 1; --i) std::swap(order[i - 1], order[random_bits(0, i, 0) % i]);
  return order;
}

std::vector<std::uint64_t> ranks_of(const WantedStatistics& wanted, std::uint64_t count) {
  std::vector<std::uint64_t> ranks;
  if (wanted.min) ranks.push_back(0);
  if (wanted.max) ranks.push_back(count - 1);
  for (const StatisticKind* kind : wanted.percentiles)
    for (const std::uint64_t rank : percentile_ranks(kind->percentile, count)) ranks.push_back(rank);
  std::sort(ranks.begin(), ranks.end());
  ranks.erase(std::unique(ranks.begin(), ranks.end()), ranks.end());
  return ranks;
}

}  // namespace

double power_to_unit(double largest) {
  int exponent = 0;
  if (largest > 0) std::frexp(largest, &exponent);
  return std::ldexp(1.0, -exponent);
}

WantedStatistics WantedStatistics::of(const std::vector<const StatisticKind*>& kinds) {
  WantedStatistics wanted{false, false, false, {}};
  for (const StatisticKind* kind : kinds) {
    if (kind->value == &Statistic::min) wanted.min = true;
    if (kind->value == &Statistic::mean) wanted.mean = true;
    if (kind->value == &Statistic::max) wanted.max = true;
    if (kind->percentile >= 0) wanted.percentiles.push_back(kind);
  }
  return wanted;
}

ColumnStatistics::ColumnStatistics(const ErrorColumns& columns, WantedStatistics wanted, unsigned threads,
                                   InstructionSet set)
    : columns_(columns),
      wanted_(std::move(wanted)),
      kernels_(select_kernels<ScreenKernels>(set)),
      configurations_(columns.configurations()),
      padded_((configurations_ + batch_size - 1) / batch_size * batch_size),
      count_(columns.columns()),
      row_size_(columns.coordinates() * count_ + columns.joints()),
      ranks_(ranks_of(wanted_, configurations_)),
      order_(shuffled(configurations_)),
      scale_(columns.coordinates()),
      constant_(columns.coordinates()),
      floats_(2 * columns.coordinates() * count_ * padded_),
      rows_(row_size_ * configurations_),
      mean_(columns.coordinates() * count_),
      mean_square_(mean_.size()),
      mean_norm_(columns.joints()),
      least_norm_(columns.joints()),
      largest_norm_(columns.joints()) {
  parallel_for(columns.coordinates(), threads, [&](std::size_t c) { fill(c); });
  for (std::size_t j = 0; j < columns.joints(); ++j) {
    const double* const norms = columns.norms(j);
    long double sum = 0;
    for (std::size_t i = 0; i < configurations_; ++i) {
      sum += norms[i];
      rows_[i * row_size_ + columns.coordinates() * count_ + j] = norms[order_[i]];
    }
    mean_norm_[j] = static_cast<double>(sum / static_cast<long double>(configurations_));
    const auto [least, largest] = std::minmax_element(norms, norms + configurations_);
    least_norm_[j] = *least;
    largest_norm_[j] = *largest;
  }
}

void ColumnStatistics::fill(std::size_t c) {
  double largest = 0;
  for (std::size_t k = 0; k < count_; ++k)
    for (std::size_t i = 0; i < configurations_; ++i)
      largest = std::max(largest, std::abs(columns_.column(c, k)[i]));
  scale_[c] = power_to_unit(largest);
  float* const linear = floats_.data() + 2 * c * count_ * padded_;
  float* const squared = linear + count_ * padded_;
  constant_[c] = true;
  for (std::size_t k = 0; k < count_; ++k) {
    const double* const column = columns_.column(c, k);
    long double sum = 0, square_sum = 0;
    double least = std::numeric_limits<double>::infinity(), most = 0;
    for (std::size_t i = 0; i < configurations_; ++i) {
      const double a = std::abs(column[order_[i]]), scaled = a * scale_[c];
      const std::size_t to = (i / batch_size * count_ + k) * batch_size + i % batch_size;
      linear[to] = static_cast<float>(scaled);
      squared[to] = static_cast<float>(scaled * scaled);
      rows_[i * row_size_ + c * count_ + k] = a;
      sum += a;
      square_sum += static_cast<long double>(a) * a;
      least = std::min(least, a);
      most = std::max(most, a);
    }
    mean_[c * count_ + k] = static_cast<double>(sum / static_cast<long double>(configurations_));
    mean_square_[c * count_ + k] =
        static_cast<double>(square_sum / static_cast<long double>(configurations_));
    // Differences of rounding in trigonometry and the lengths of links.
    constant_[c] = constant_[c] && most - least <= 1e-14 * largest;
  }
}

void ColumnStatistics::evaluate(std::size_t coordinate, bool squared,
                                std::span<const ColumnForm> forms) const {
  FormStatistics tile(*this, coordinate, squared);
  for (std::size_t first = 0; first < forms.size(); first += forms_per_tile)
    tile.evaluate(forms.subspan(first, std::min(forms_per_tile, forms.size() - first)));
}

namespace {

/// Collects the forms of all models at one coordinate.
class CoordinateForms {
 public:
  CoordinateForms(std::size_t coordinate, std::span<const ColumnModel> models,
                  std::vector<Workspace>& results)
      : c_(coordinate), row_(static_cast<Eigen::Index>(coordinate)) {
    for (std::size_t m = 0; m < models.size(); ++m) {
      add_bounds(models[m], results[m]);
      for (std::size_t f = 0; f < models[m].filters->size(); ++f) add_filtered(models[m], f, results[m]);
    }
  }

  std::vector<ColumnForm> linear, squared;

 private:
  void add_bounds(const ColumnModel& m, Workspace& w) {
    CoordinateStatistics& s = w.coordinates[c_];
    const Coordinate c = m.model->coordinates[c_];
    linear.push_back({.weights = m.weights.half_width.data(),
                      .added = m.weights.added_worst[row_],
                      .statistic = &s.worst_case,
                      .rigorous = &s.worst_case_rigorous,
                      .remainder = &m.weights.remainder,
                      .rotation = !is_position(c)});
    squared.push_back({.weights = m.weights.variance.data(),
                       .added = m.weights.added_variance[row_],
                       .statistic = &s.sigma});
  }

  /// Sigma behind a filter, where it is no multiple of that before it.
  void add_filtered(const ColumnModel& m, std::size_t f, Workspace& w) {
    const ErrorWeights::Filtered& own = m.weights.filtered[f];
    DerivativeStatistics& s = w.derivatives[f][c_];
    if (own.variance.size() > 0) {
      s.sigma.emplace();
      if (!is_plain(*m.model))
        squared.push_back(
            {.weights = own.variance.data(), .added = own.added_variance[row_], .statistic = &*s.sigma});
    }
    if (!is_plain(*m.model)) {
      s.sigma_quantization.emplace();
      squared.push_back(
          {.weights = own.variance_of_quantization.data(), .added = 0, .statistic = &*s.sigma_quantization});
    }
    if (own.variance_in_motion.size() == 0) return;
    s.sigma_in_motion.emplace();
    squared.push_back({.weights = own.variance_in_motion.data(),
                       .added = own.added_variance[row_],
                       .statistic = &*s.sigma_in_motion});
  }

 public:
  /// Only quantization: behind a filter every figure is a multiple.
  static bool is_plain(const OperationalModel& model) { return model.sources.empty() && !model.along_motion; }

 private:
  std::size_t c_;
  Eigen::Index row_;
};

/// Statistics of (x - less) factor + more.
Statistic affine(Statistic s, double less, double factor, double more) {
  for (const StatisticKind& kind : statistic_kinds()) s.*kind.value = (s.*kind.value - less) * factor + more;
  return s;
}

void add_derivatives(const ColumnModel& m, Workspace& w) {
  for (std::size_t f = 0; f < m.filters->size(); ++f)
    for (std::size_t c = 0; c < w.coordinates.size(); ++c) {
      const auto row = static_cast<Eigen::Index>(c);
      const ErrorWeights::Filtered& own = m.weights.filtered[f];
      DerivativeStatistics& s = w.derivatives[f][c];
      s.worst_case =
          CoordinateForms::is_plain(*m.model)
              ? scaled(w.coordinates[c].worst_case, own.l1)
              : affine(w.coordinates[c].worst_case, m.weights.added_worst[row], own.l1, own.added_worst[row]);
      if (s.sigma && CoordinateForms::is_plain(*m.model))
        s.sigma = scaled(w.coordinates[c].sigma, (*m.filters)[f].h2);
    }
}

Eigen::MatrixXd variance_parts(const ColumnStatistics& columns, const OperationalModel& model) {
  Eigen::MatrixXd parts =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(model.coordinates.size()),
                            static_cast<Eigen::Index>(model.transmission.encoders.size()));
  for (Eigen::Index c = 0; c < parts.rows(); ++c) {
    const auto coordinate = static_cast<std::size_t>(c);
    for (const IndependentError& e : independent_errors(model))
      parts(c, static_cast<Eigen::Index>(e.owner)) +=
          columns.mean_square(coordinate, columns.columns().column_of(e)) * (e.sigma * e.sigma);
  }
  return parts;
}

}  // namespace

bool have_columns(const OperationalModel& model, const Configurations& configurations,
                  const WantedStatistics& wanted) {
  const std::uint64_t count = size(configurations);
  const bool euler = std::any_of(model.coordinates.begin(), model.coordinates.end(), is_euler_angle);
  const bool biased =
      !mean_errors(model.transmission).isZero(0) ||
      std::any_of(model.sources.begin(), model.sources.end(), [](const auto& s) { return s.mean != 0; });
  return count >= ColumnStatistics::fewest_configurations &&
         (wanted.percentiles.empty() || count <= exact_percentiles_limit) && !euler && !biased &&
         model.lengths.empty() && model.signals.empty();
}

std::vector<Workspace> workspaces(const ColumnStatistics& columns, std::span<const ColumnModel> models) {
  std::vector<Workspace> results(models.size());
  const std::size_t coordinates = columns.columns().coordinates();
  for (std::size_t m = 0; m < models.size(); ++m) {
    results[m].count = columns.columns().configurations();
    results[m].coordinates.resize(coordinates);
    results[m].derivatives.assign(models[m].filters->size(), std::vector<DerivativeStatistics>(coordinates));
    results[m].mean_variance_parts = variance_parts(columns, *models[m].model);
  }
  for (std::size_t c = 0; c < coordinates; ++c) {
    const CoordinateForms forms(c, models, results);
    columns.linear(c, forms.linear);
    columns.squared(c, forms.squared);
  }
  for (std::size_t m = 0; m < models.size(); ++m) add_derivatives(models[m], results[m]);
  return results;
}

}  // namespace qerr
