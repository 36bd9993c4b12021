#pragma once

#include <Eigen/Core>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace qerr {

/// What is told of an error. Of the position: the first three; behind a filter: the first, and the last
/// three.
enum class Bound { worst_case, worst_case_rigorous, sigma, sigma_quantization, sigma_in_motion };

/// The bounds of the position, and those behind a filter, in the order of reports.
std::span<const Bound> bounds_of(bool behind_filter);

/// `worst_case`, as requirements and reports name it.
std::string_view name_of(Bound);
/// What it is, in a sentence of a list.
std::string_view summary_of(Bound);

/// Whether it is a variance's root; else it is a worst case.
constexpr bool is_sigma(Bound b) { return b >= Bound::sigma; }

/// A number at each configuration: a bound of a signal, behind a filter or not.
struct Figure {
  std::size_t signal = 0;      ///< index into all_signals of the model
  std::ptrdiff_t filter = -1;  ///< index into the filters; -1: the unfiltered position
  Bound bound = Bound::worst_case;

  friend auto operator<=>(const Figure&, const Figure&) = default;
};

/// Distribution of a quantity over the configurations. Percentiles interpolate linearly between order
/// statistics.
struct Statistic {
  double min = 0, mean = 0, max = 0, p50 = 0, p95 = 0, p99 = 0;
  Eigen::VectorXd at_max;  ///< the first configuration that has the maximum, independent joints [rad or m]
};

/// A member of Statistic. A new one is a member there and a row in the list of statistic.cpp.
struct StatisticKind {
  std::string_view name;     ///< in specs and reports
  std::string_view heading;  ///< of its column in tables; empty: in JSON and CSV only
  std::string_view summary;
  double Statistic::*value;
  double percentile = -1;  ///< fraction of the values below it; negative: not a percentile
};

/// The statistic that is a bound of the maximum over the whole joint ranges (proven_maximum.hpp) in place of
/// one over the configurations: no member of Statistic.
inline constexpr std::string_view proven_statistic = "proven_max";

/// All of them, in the order of the reports.
std::span<const StatisticKind> statistic_kinds();

/// The kind of a name; null: unknown.
const StatisticKind* find_statistic(std::string_view name);

/// Statistics of the quantity times a factor >= 0.
Statistic scaled(const Statistic&, double factor);

/// Up to this many values percentiles are exact; beyond they are read off a histogram (histogram.hpp).
inline constexpr std::uint64_t exact_percentiles_limit = std::uint64_t{1} << 17;

}  // namespace qerr
