#include "diagnose/search/rounding_test.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/probability.hpp"
#include "core/random.hpp"
#include "effect/effects/effects.hpp"

namespace qerr {

namespace {

constexpr int draws = 9;
constexpr double rounding_refuted = 0.01;

/// Decrease of the weighted sum of squares by a candidate beside others, in another record of the same
/// motion; none where that record has too few samples to fit them.
double gain_in(const ErrorModel& m, const Evidence& simulated, std::uint64_t seed,
               const LinearModel::Set& others, std::size_t extra) {
  const ErrorSamples s = error_samples(simulated, seed, most_samples);
  if (s.size() < fewest_samples) return 0;
  std::vector<ColumnGroup> groups;
  Eigen::MatrixXd columns = Eigen::MatrixXd::Ones(s.size(), m.base());
  LinearModel::Set with = others;
  with.push_back(extra);
  for (const std::size_t g : with) {
    const Term t = searchable(m.candidate(g).over(s.sampling));
    groups.push_back({columns.cols(), t.size(), static_cast<int>(groups.size())});
    columns.conservativeResize(Eigen::NoChange, columns.cols() + t.size());
    columns.rightCols(t.size()) = t.columns.matrix();
  }
  const Eigen::ArrayXd weight = m.weights(s);
  const LinearModel model(columns, s.error.matrix(), weight.matrix(), m.base());
  std::iota(with.begin(), with.end(), std::size_t{0});
  const LinearModel::Set without(with.begin(), with.end() - 1);
  return (model.fit(groups, without).rss - model.fit(groups, with).rss) * m.weight().sum() / weight.sum();
}

/// Mean decrease of the weighted sum of squares by a candidate in simulations of a model without it.
double expected_gain(const ErrorModel& m, const LinearModel::Set& without, const LinearModel::Fit& f,
                     std::size_t extra, std::uint64_t seed) {
  const Evidence& record = m.record();
  std::vector<RowGroup> rows;
  for (Eigen::Index k = 0; k < record.rows(); ++k) rows.push_back({k, k + 1});
  const Sampling every(record, std::move(rows));
  Eigen::ArrayXd added = Eigen::ArrayXd::Constant(record.rows(), m.base() > 0 ? f.coefficients[0] : 0);
  for (std::size_t i = 0; i < without.size(); ++i)
    added += addition(searchable(m.candidate(without[i]).over(every)), m.coefficients(without, f, i));
  double sum = 0;
  for (int draw = 0; draw < draws; ++draw) {
    Evidence simulated = record;
    const std::uint64_t stream = stream_seed(seed, "surrogate", static_cast<std::uint64_t>(draw));
    for (Eigen::Index k = 0; k < record.rows(); ++k)
      simulated.measured[k] =
          quantize(record.encoder, record.path[k] + added[k] +
                                       record.path_noise * normal(stream, static_cast<std::uint64_t>(k)));
    sum += gain_in(m, simulated, seed, without, extra);
  }
  return sum / draws;
}

}  // namespace

std::vector<std::string> brought_by_rounding(const ErrorModel& m, const Choice& choice, std::uint64_t seed) {
  std::vector<std::string> families;
  for (std::size_t i = 0; i < choice.chosen.size(); ++i) {
    LinearModel::Set without = choice.chosen;
    without.erase(without.begin() + static_cast<std::ptrdiff_t>(i));
    const LinearModel::Fit rest = m.fit(without);
    const double lost = rest.rss - choice.fit.rss;
    // Rounding alone does not bring more than a count.
    if (lost > m.weight().sum() * m.record().step() * m.record().step()) continue;
    const double expected = expected_gain(m, without, rest, choice.chosen[i], seed);
    const auto d = static_cast<double>(m.term(choice.chosen[i]).size());
    if (fisher_f_tail(lost / std::max(expected, 1e-300), d, draws * d) >= rounding_refuted)
      families.push_back(m.candidate(choice.chosen[i]).family);
  }
  return families;
}

}  // namespace qerr
