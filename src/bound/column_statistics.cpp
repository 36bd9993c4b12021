#include <algorithm>
#include <cmath>
#include <deque>
#include <tuple>
#include <utility>

#include "bound/error_columns.hpp"
#include "core/parallel.hpp"
#include "lanes/batch.hpp"

namespace qerr {

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
      kernels_(select_kernels<BoundKernels>(set)),
      mean_square_(columns.coordinates() * columns.columns()) {
  parallel_for(mean_square_.size(), threads, [&](std::size_t i) {
    const double* const column = columns.column(i / columns.columns(), i % columns.columns());
    long double sum = 0;
    for (std::size_t at = 0; at < columns.configurations(); ++at)
      sum += static_cast<long double>(column[at]) * column[at];
    mean_square_[i] = static_cast<double>(sum / static_cast<long double>(columns.configurations()));
  });
}

void ColumnStatistics::evaluate(std::size_t coordinate, std::span<const ColumnForm> forms) const {
  constexpr std::size_t most_values = std::size_t{1} << 23;  // 64 MB a thread
  const std::size_t kept = keeps_all() ? columns_.configurations() : 0;
  const std::size_t tile =
      std::clamp<std::size_t>(most_values / std::max<std::size_t>(kept, 1), 1, forms_per_tile);
  const auto values = std::make_unique_for_overwrite<double[]>(std::min(tile, forms.size()) * kept);
  for (std::size_t first = 0; first < forms.size(); first += tile)
    evaluate_tile(coordinate, forms.subspan(first, std::min(tile, forms.size() - first)), values.get());
}

/// How many of the largest values have the wanted percentiles.
std::size_t ColumnStatistics::wanted_values() const {
  std::size_t most = 0;
  for (const StatisticKind* kind : wanted_.percentiles)
    most = std::max(most, columns_.configurations() -
                              percentile_ranks(kind->percentile, columns_.configurations()).front());
  return most;
}

/// LargestValues take less time than all of them where few are wanted.
bool ColumnStatistics::keeps_all() const { return 16 * wanted_values() > columns_.configurations(); }

/// The columns of a coordinate, then the norms of the joints, from a configuration on.
std::vector<const double*> ColumnStatistics::columns_from(std::size_t coordinate, std::size_t first) const {
  std::vector<const double*> columns;
  for (std::size_t k = 0; k < columns_.columns(); ++k)
    columns.push_back(columns_.column(coordinate, k) + first);
  for (std::size_t j = 0; j < columns_.joints(); ++j) columns.push_back(columns_.norms(j) + first);
  return columns;
}

/// What keeps the largest values of each form, with what a sample of the batches says of them.
std::vector<LargestValues> ColumnStatistics::largest_values(std::size_t coordinate,
                                                            std::span<const ColumnForm> forms,
                                                            bool sampled) const {
  constexpr std::size_t every = 32;  // a thirtieth of the time of all batches
  std::vector<std::vector<double>> samples(forms.size());
  AlignedNumbers figures(forms.size() * batch_size);
  const std::size_t batches = sampled ? columns_.configurations() / batch_size : 0;  // whole ones
  for (std::size_t b = 0; b < batches; b += every) {
    kernels_.forms(columns_from(coordinate, b * batch_size).data(), forms.size(), forms.data(), wanted_.mean,
                   figures.data());
    for (std::size_t f = 0; f < forms.size(); ++f)
      samples[f].insert(samples[f].end(), figures.data() + f * batch_size,
                        figures.data() + (f + 1) * batch_size);
  }
  std::vector<LargestValues> largest;
  for (std::vector<double>& sample : samples) largest.emplace_back(wanted_values(), sample, every);
  return largest;
}

/// @param values   memory for those of every form, if it keeps all
/// @param sampled  whether a sample may say which values are among the largest
void ColumnStatistics::evaluate_tile(std::size_t coordinate, std::span<const ColumnForm> forms,
                                     double* values, bool sampled) const {
  constexpr std::size_t batches_per_sum = 64;  // as in `workspace`: long sums of double lose digits
  const std::size_t configurations = columns_.configurations();
  AlignedNumbers figures(forms.size() * batch_size);
  std::vector<Tally> tallies(forms.size());
  std::vector<JoinedTally> joined(forms.size());
  const bool all = keeps_all();
  std::vector<LargestValues> largest;
  if (!all && wanted_values() > 0) largest = largest_values(coordinate, forms, sampled);
  std::vector<const double*> columns = columns_from(coordinate, 0);
  for (std::size_t first = 0, joined_up_to = 0; first < configurations; first += batch_size) {
    const std::size_t count = std::min(batch_size, configurations - first), end = first + count;
    kernels_.forms(columns.data(), forms.size(), forms.data(), wanted_.mean, figures.data());
    for (const double*& column : columns) column += batch_size;
    if (count == batch_size) kernels_.tally(forms.size(), figures.data(), first, tallies.data(), nullptr);
    for (std::size_t f = 0; f < forms.size(); ++f) {
      const double* const own = figures.data() + f * batch_size;
      if (count < batch_size) tally_some(own, count, first, tallies[f]);
      if (all) std::copy_n(own, count, values + f * configurations + first);
      if (!largest.empty()) largest[f].add(kernels_, own, count);
    }
    if (end < configurations && end - joined_up_to < batches_per_sum * batch_size) continue;
    for (std::size_t f = 0; f < forms.size(); ++f)
      joined[f].append(std::exchange(tallies[f], Tally{}), end - joined_up_to);
    joined_up_to = end;
  }
  for (std::size_t f = 0; f < forms.size(); ++f) {
    OrderStatistic order;
    if (all) order = order_statistics({values + f * configurations, configurations}, joined[f]);
    if (!largest.empty() && !largest[f].complete()) {
      evaluate_tile(coordinate, forms.subspan(f, 1), values, false);
      continue;
    }
    if (!largest.empty()) order = std::move(largest[f]).order_statistics();
    set(*forms[f].statistic, joined[f], order, forms[f].squared && !wanted_.mean);
  }
}

/// @param squares  whether the values are squares of the figure's, as their roots are needed for means only
void ColumnStatistics::set(Statistic& s, const JoinedTally& tally, const OrderStatistic& order,
                           bool squares) const {
  const auto value = [&](double number) { return squares ? std::sqrt(number) : number; };
  if (wanted_.min) s.min = value(tally.min());
  if (wanted_.mean) s.mean = tally.mean();
  if (wanted_.max) s.max = value(tally.max());
  for (const StatisticKind* kind : wanted_.percentiles)
    s.*kind->value =
        percentile(kind->percentile, tally.count(), [&](std::uint64_t rank) { return value(order(rank)); });
}

namespace {

class CoordinateForms {
 public:
  CoordinateForms(const ErrorColumns& columns, std::size_t coordinate, std::span<const ColumnModel> models,
                  std::vector<Workspace>& results)
      : columns_(columns), c_(coordinate), row_(coordinate) {
    for (std::size_t m = 0; m < models.size(); ++m) {
      add_bounds(models[m], results[m]);
      for (std::size_t f = 0; f < models[m].filters->size(); ++f) add_filtered(models[m], f, results[m]);
    }
  }

  /// Those of one shape side by side.
  std::span<const ColumnForm> all() {
    std::ranges::stable_sort(all_, [](const ColumnForm& a, const ColumnForm& b) {
      return std::tuple(a.squared, a.columns, !a.means) < std::tuple(b.squared, b.columns, !b.means);
    });
    return all_;
  }

  /// Only quantization: behind a filter every figure is a multiple.
  static bool is_plain(const OperationalModel& model) { return model.sources.empty() && !model.along_motion; }

 private:
  ColumnForm& add(const Eigen::VectorXd& weights, double added, Statistic& s, bool squared) {
    return all_.emplace_back(
        ColumnForm{weights.data(), static_cast<std::size_t>(weights.size()), added, &s, squared});
  }
  /// The vector, which outlives the forms.
  const Eigen::VectorXd& kept(Eigen::VectorXd v) { return kept_.emplace_back(std::move(v)); }

  void add_bounds(const ColumnModel& m, Workspace& w) {
    const ErrorWeights& weights = m.weights;
    const double added = weights.added_worst[row_];
    CoordinateStatistics& s = w.coordinates[c_];
    const double* const means = weights.biased() ? kept(with_norms(weights.mean, {})).data() : nullptr;
    add(weights.half_width, added, s.worst_case, false).means = means;
    const LinearizationRemainder& r = weights.remainder;
    const bool position = is_position(m.model->coordinates[c_]);
    ColumnForm& rigorous =
        add(position ? kept(with_norms(weights.half_width, r.per_column)) : weights.half_width,
            added + (position ? r.position : r.rotation), s.worst_case_rigorous, false);
    rigorous.means = means;
    if (!position) rigorous.most = r.rotation_angle + added;
    add(weights.variance, weights.added_variance[row_], s.sigma, true);
  }

  /// @param of_norms  empty: zeros
  Eigen::VectorXd with_norms(const Eigen::VectorXd& weights, const Eigen::VectorXd& of_norms) const {
    Eigen::VectorXd all =
        Eigen::VectorXd::Zero(weights.size() + static_cast<Eigen::Index>(columns_.joints()));
    all.head(weights.size()) = weights;
    all.segment(weights.size(), of_norms.size()) = of_norms;
    return all;
  }

  /// What is behind a filter, where it is no multiple of that before it.
  void add_filtered(const ColumnModel& m, std::size_t f, Workspace& w) {
    const ErrorWeights::Filtered& own = m.weights.filtered[f];
    const bool plain = is_plain(*m.model);
    DerivativeStatistics& s = w.derivatives[f][c_];
    if (m.weights.biased())
      add(kept(own.l1 * m.weights.half_width), own.added_worst[row_], s.worst_case, false).means =
          kept(own.dc_gain * m.weights.mean).data();
    if (own.variance.size() > 0) s.sigma.emplace();
    if (s.sigma && !plain) add(own.variance, own.added_variance[row_], *s.sigma, true);
    if (!plain) add(own.variance_of_quantization, 0, s.sigma_quantization.emplace(), true);
    if (own.variance_in_motion.size() > 0)
      add(own.variance_in_motion, own.added_variance[row_], s.sigma_in_motion.emplace(), true);
  }

  const ErrorColumns& columns_;
  std::size_t c_;
  Eigen::Index row_;
  std::vector<ColumnForm> all_;
  std::deque<Eigen::VectorXd> kept_;
};

/// Statistics of (x - less) factor + more.
Statistic affine(Statistic s, double less, double factor, double more) {
  for (const StatisticKind& kind : statistic_kinds()) s.*kind.value = (s.*kind.value - less) * factor + more;
  return s;
}

void add_derivatives(const ColumnModel& m, Workspace& w) {
  for (std::size_t f = 0; f < m.filters->size(); ++f)
    for (std::size_t c = 0; c < w.coordinates.size(); ++c) {
      const ErrorWeights::Filtered& own = m.weights.filtered[f];
      DerivativeStatistics& s = w.derivatives[f][c];
      if (!m.weights.biased())
        s.worst_case =
            CoordinateForms::is_plain(*m.model)
                ? scaled(w.coordinates[c].worst_case, own.l1)
                : affine(w.coordinates[c].worst_case, m.weights.added_worst[c], own.l1, own.added_worst[c]);
      if (s.sigma && CoordinateForms::is_plain(*m.model))
        s.sigma = scaled(w.coordinates[c].sigma, (*m.filters)[f].h2);
    }
}

Eigen::MatrixXd variance_parts(const ColumnStatistics& columns, const OperationalModel& model) {
  Eigen::MatrixXd parts =
      Eigen::MatrixXd::Zero(std::ssize(model.coordinates), std::ssize(model.transmission.encoders));
  for (Eigen::Index c = 0; c < parts.rows(); ++c) {
    const auto coordinate = static_cast<std::size_t>(c);
    for (const IndependentError& e : independent_errors(model))
      parts(c, e.owner) +=
          columns.mean_square(coordinate, columns.columns().column_of(e)) * (e.sigma * e.sigma);
  }
  return parts;
}

}  // namespace

bool have_columns(const OperationalModel& model) {
  return model.lengths.empty() && model.signals.empty() &&
         std::ranges::none_of(model.coordinates, is_euler_angle);
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
    columns.evaluate(c, CoordinateForms(columns.columns(), c, models, results).all());
  }
  for (std::size_t m = 0; m < models.size(); ++m) add_derivatives(models[m], results[m]);
  return results;
}

}  // namespace qerr
