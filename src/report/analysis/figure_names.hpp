#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/input/spec.hpp"
#include "qerr/report/analysis.hpp"

namespace qerr {

/// What a figure of an analysis belongs to: the columns of its rows in CSV.
struct FigureName {
  Figure figure;
  std::string_view signal;  ///< `position` or `derivative`, `torque`, `closed_position`, ...
  std::string filter;       ///< "" of the position, and of signals of controllers and loops
  std::string coordinate;
  std::string unit;
  std::string_view bound;
  std::string shown_unit;  ///< in pages: "" of a control law that states none

  /// `position.x.worst_case`, `velocity.x.sigma`: as requirements name it.
  std::string quantity() const;
};

/// Every figure that a spec can have, in the order of CSV: of the position by signal, then by filter and
/// signal.
std::vector<FigureName> all_figures(const Spec&);

FigureName name_of(const Spec&, const Figure&);

/// Calls `see` with every figure that the analysis has.
void for_each_figure(const Analysis&, const std::function<void(const FigureName&, const Statistic&)>& see);

/// A figure with one value over all configurations: of a loop, a wall, a gain, or a counter.
struct SingleFigure {
  std::string quantity;        ///< as requirements name it: `loop.a1.gain_margin`, `encoder.a1.count_rate`
  std::string unit;            ///< SI; "": none
  std::string_view statistic;  ///< over the configurations, `max` or `min`
  double value = 0;            ///< infinite: unbounded; NaN: not known, as of an unstable loop's margins
};

/// Those that the analysis has.
std::vector<SingleFigure> single_figures(const Analysis&);

inline constexpr std::string_view analysis_csv_header = "signal,filter,coordinate,unit,bound,statistic,value";

/// Every kind, in the order of reports.
std::vector<const StatisticKind*> all_statistics();

/// The rows of the analysis in CSV, without the header.
/// @param before  cells at the begin of each row, with their commas
std::string analysis_csv_rows(const Analysis&, const std::string& before,
                              const std::vector<const StatisticKind*>& statistics);

/// The columns of `qerr analyze --per-configuration`, as CSV and as numbers.

struct ConfigurationBatch;

/// Joint coordinates of a configuration of a batch [rad or m].
Eigen::VectorXd configuration_of(const ConfigurationBatch&, std::size_t i, const Chain&);

/// The headers of the columns.
/// @param noise  of `noise_in_motion`
std::vector<std::string> per_configuration_names(const Spec&, const std::vector<Eigen::VectorXd>& noise);

/// The values of the configurations of a batch, a row each; NaN where sigma is not known.
/// @param spec  its model as the errors were computed with, error sources of the effects included
std::vector<double> per_configuration_numbers(const Spec& spec, const std::vector<Eigen::VectorXd>& noise,
                                              const ConfigurationBatch&);

/// @param noise  of `noise_in_motion`
std::string per_configuration_header(const Spec&, const std::vector<Eigen::VectorXd>& noise);

/// One row for each configuration of the batch.
/// @param spec  its model as the errors were computed with, error sources of the effects included
std::string per_configuration_rows(const Spec& spec, const std::vector<Eigen::VectorXd>& noise,
                                   const ConfigurationBatch&);

}  // namespace qerr
