#include "bound/column_workspace.hpp"

#include <algorithm>
#include <limits>

namespace qerr {

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

bool have_columns(const OperationalModel& model, const Configurations& configurations) {
  const std::uint64_t count = size(configurations);
  const bool euler = std::any_of(model.coordinates.begin(), model.coordinates.end(), is_euler_angle);
  const bool biased =
      !mean_errors(model.transmission).isZero(0) ||
      std::any_of(model.sources.begin(), model.sources.end(), [](const auto& s) { return s.mean != 0; });
  return count >= ColumnStatistics::fewest_configurations && count <= exact_percentiles_limit && !euler &&
         !biased && model.lengths.empty() && model.signals.empty();
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
