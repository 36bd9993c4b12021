#pragma once

#include <string>
#include <utility>
#include <vector>

#include "qerr/report/simulation_report.hpp"

namespace qerr {

/// A signal of the report and its names. Borrows the signal from the report.
struct NamedSignal {
  const SimulatedSignal& signal;
  std::string filter;  ///< "position" for the unfiltered signal
  std::string coordinate, unit;
};

/// All signals, in the order of every format. Valid as long as the report.
std::vector<NamedSignal> signals_of(const SimulationReport&);

/// Names and values.
using Figures = std::vector<std::pair<const char*, double>>;

/// Simulated sigma, mean and peak of a signal, and the bounds that they are compared with.
Figures figures_of(const SimulatedSignal&);

/// Factors from the IPQN sigma to the simulated one.
Figures factors_of(const Ladder&);

}  // namespace qerr
