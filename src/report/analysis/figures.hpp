#pragma once

#include <Eigen/Core>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "bound/control_bounds.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/report/analysis.hpp"
#include "qerr/report/write.hpp"
#include "report/text_table.hpp"

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

/// `velocity.x.sigma p99 is 1.20 mm/s, at most 1.00 mm/s is required`.
std::string verdict(const Requirement&, const RequirementResult&);

/// A value of a requirement with its unit; of the loop of an unstable joint `unstable`.
std::string value_text(const Requirement&, double value);

/// `velocity.x.sigma p99 <= 1.00 mm/s`.
std::string limited(const Requirement&);

/// A fault of a requirement. @param name  that it shows; "": the quantity
Error requirement_error(const Requirement&, const std::string& rule, const std::string& remedy,
                        const std::string& name = "");

/// A fault of a section of a spec, or of one that it lacks.
Error spec_error(const Spec&, const std::string& key, const std::string& rule, const std::string& found,
                 const std::string& remedy);

/// How a value is to its limit: `<=`, or `>` where the limit is not met; of a lower limit `>=` or `<`.
std::string relation(bool at_least, bool met);

/// `j1 0.12 rad, j2 -1.5 rad`. @param text  of a joint's name and value
std::string configuration_text(
    const Chain&, const Eigen::VectorXd& q,
    const std::function<std::string(const IndependentJoint&, double value)>& text = {});

/// What may decide a requirement whose limit lies between what is reached and what is proven.
inline constexpr std::string_view undecided_remedy = "a smaller gap may decide: --prove GAP";

/// The analysis at no more than a few hundred of the configurations, for questions that do not depend on
/// more.
Analysis analysis_of_some(const Spec&, unsigned threads);

/// What `check` says of the requirements of a spec, at some configurations.
/// @throws Error (input) if they cannot be judged
std::string verdicts_of_some(const Spec&, unsigned threads);

/// What `analyze` and `check` say of a spec, at some configurations.
/// @param format  csv: the figures that `sweep` gives of a variant
std::string figures_of_some(const Spec&, unsigned threads, const std::string& format = "json");

/// The requirements of a spec for a page about something else: empty if they cannot be judged, or not in a
/// second.
std::optional<std::vector<RequirementResult>> verdicts_beside(const Spec&);

/// How far a value is within its limit, relative to it; negative if it is beyond, NaN for a limit of 0.
double margin(double value, double limit, bool at_least);
double margin(const Requirement&, const RequirementResult&);
/// The margin for people; "" if there is none.
std::string margin_text(const Requirement&, const RequirementResult&);

/// The part of a limit that a value takes: value over limit, of a lower limit limit over value. A requirement
/// is met up to 1; empty for a limit that is not positive, and a value that is unbounded or of another sign.
std::optional<double> part_of_limit(const Requirement&, const RequirementResult&);

/// Refuses limits of quantities that no error reaches: 0 at all configurations, whatever the encoders; or
/// that only the rounding of the URDF's angles lets it reach.
/// @param key  that states them
/// @throws Error (input)
void refuse_unreached(const Analysis&, const std::vector<Requirement>& limits, const std::string& key);
void refuse_unreached(const Analysis&);

/// The requirements of an analysis whose bounds are computed.
/// @throws Error (input) like `evaluate` and refuse_unreached
std::vector<RequirementResult> requirement_results(const Analysis&);

/// Counts, during an analysis, the configurations at which bounds exceed limits, and where the tip is there.
///
///     ExceedanceCounter counter(spec, limits);
///     options.visit = counter.visitor();
///     Analysis a = analyze(spec, options);
///     a.exceedances = counter.result(a);
class ExceedanceCounter {
 public:
  /// @param spec    with the lengths of the limits among its coordinates
  /// @param limits  at_most, of bounds of coordinates; their statistic has no meaning here
  ExceedanceCounter(const Spec& spec, std::vector<Requirement> limits);

  /// For WorkspaceOptions::visit. @pre the counter outlives the analysis
  std::function<void(const ConfigurationBatch&)> visitor() {
    return [this](const ConfigurationBatch& batch) { count(batch); };
  }

  /// @throws Error (usage) if a bound is not known: sigma behind a filter, of errors of unknown spectrum
  std::vector<Exceedance> result(const Analysis&) const;

 private:
  void count(const ConfigurationBatch&);
  void add(Exceedance&, const Eigen::Vector3d& tip, bool above) const;

  Chain chain_;
  std::vector<Norms> filters_;
  std::vector<Requirement> limits_;
  std::vector<Figure> figures_;  // of the limits
  double step_;                  // between the distances of two shells [m]
  std::mutex guard_;
  std::vector<Exceedance> counts_;  // [limit]; sums and extremes do not depend on the order of the batches
};

}  // namespace qerr

/// The section of `analyze` about loops and walls, and its figures in requirements.
namespace qerr {

/// The largest kd with which a joint's torque meets its requirements, the loop open and kp as stated.
struct GainReport {
  std::size_t joint = 0;
  double kd = 0;         ///< [N m s/rad or N s/m]
  std::string quantity;  ///< the requirement that limits it
};

/// Loops of all joints whose inertia is known, and all walls for which everything is stated.
struct ControlReport {
  std::vector<OpenTorque> torques;  ///< of joints with a controller
  std::vector<WorstLoop> loops;
  std::vector<WorstWall> walls;
  std::vector<GainReport> gains;  ///< of joints with a requirement on their torque
};

/// Loops and walls are evaluated at this many configurations at most, the first of the spec.
inline constexpr std::uint64_t configurations_of_control = 10'000;

/// Over the configurations of the spec, of more than 10000 the first.
/// @param required_only  without torques, and loops of joints that no requirement of the spec names
ControlReport control_report(const Spec&, bool required_only = false);

/// Refuses requirements on loops and walls beside effects that change them in a way that is not counted.
/// @throws Error (input; key `requirements`)
void refuse_changed_loops(const Spec&);

/// The value of a requirement on a figure of a loop or a wall: infinite if unbounded, NaN for an unstable
/// loop, which meets no limit.
/// @throws Error (input) if it needs what is not stated
double control_value(const Requirement&, const Spec&, const ControlReport&);

/// The least margin, bandwidth, stiffness and gain over the configurations, the largest cycle.
std::vector<SingleFigure> control_rows(const Spec&, const ControlReport&);

/// Whether a requirement is on such a figure.
bool any_of_control(const Spec&);

/// One for each unstable loop and each wall that lacks a statement.
std::vector<std::string> control_warnings(const Spec&, const ControlReport&);

/// A table of torques, loops or walls for people, its header first, with remarks below it.
struct ControlTable {
  std::string title;
  TableRows rows;
  std::vector<std::string> notes;
};
std::vector<ControlTable> control_tables(const Spec&, const ControlReport&);

/// They as sections of a terminal's table.
std::string control_text(const Spec&, const ControlReport&, const Style&);

}  // namespace qerr
