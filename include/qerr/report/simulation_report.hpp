#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "qerr/input/spec.hpp"
#include "qerr/simulate/simulate.hpp"

namespace qerr {

/// The answer of `qerr simulate`.
struct SimulationReport {
  Spec spec;
  Simulation simulation;
  std::uint64_t seed = 1;
  std::vector<std::string> warnings;
};

/// Runs the spec's motion.
/// @throws Error (input; key `motion`) when the spec has none
SimulationReport simulation_report(const Spec&, const SimulationOptions&);

/// Header and rows of the log that `qerr diagnose` reads: time; of every joint its encoder's counts (or what
/// a file with a grid of its own has instead, `measured`), the reference, and the effort where the URDF has
/// masses; the tip.
class LogWriter {
 public:
  explicit LogWriter(const Spec&);
  std::string header() const;

  /// The row of one reading; the text is valid until the next call.
  std::string_view row(const Reading&);

 private:
  const Spec& spec_;
  bool efforts_;
  std::vector<bool> rounded_;  // joints whose file has a grid of its own: measured instead of counts
  std::string text_;
};

}  // namespace qerr
