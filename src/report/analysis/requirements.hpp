#pragma once

#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/report/analysis.hpp"

namespace qerr {

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
