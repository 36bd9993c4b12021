#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/input/spec.hpp"
#include "qerr/simulate/simulate.hpp"

namespace qerr {

/// One filter with several cut-offs: the filters of a spec, in this order.
struct CutoffSearch {
  std::string filter;          ///< its name in the spec of the user
  std::vector<double> values;  ///< [Hz]
};

/// The result of `qerr simulate`.
struct SimulationReport {
  Spec spec;
  Simulation simulation;
  std::uint64_t seed = 1;
  std::vector<std::string> warnings;
  std::optional<CutoffSearch> cutoffs = {};
  /// The filters of derivative 1 and the estimators of the spec, the least error of each joint first; empty:
  /// not asked for.
  std::vector<EstimatedVelocity> estimators = {};
};

/// Simulates the spec's motion.
/// @throws Error (input; key `motion`) if the spec has none
SimulationReport simulation_report(const Spec&, const SimulationOptions&);

/// The spec's filters with derivative 1 and its estimators, compared along its motion.
/// @throws Error (input; key `estimators` or `motion`) if there is nothing to compare, or too much
std::vector<EstimatedVelocity> estimator_comparison(const Spec&, const SimulationOptions&);

/// Effects of the spec that estimators which time edges do not see: those behind the disc.
std::vector<std::string> estimator_warnings(const Spec&);

/// Header and rows of the log that `qerr diagnose` reads: time; of every joint its encoder's counts
/// (`measured` if the log has a resolution of its own), the reference, and the effort if the URDF has masses;
/// the tip. Holds a reference to the spec, which must outlive it.
class LogWriter {
 public:
  explicit LogWriter(const Spec&);
  explicit LogWriter(Spec&&) = delete;
  std::string header() const;

  /// The row of one reading; the text is valid until the next call.
  std::string_view row(const Reading&);

 private:
  const Spec& spec_;
  bool efforts_, temperatures_;
  std::vector<bool> rounded_;  // joints with a log resolution: `measured` instead of `counts`
  std::string text_;
};

}  // namespace qerr
