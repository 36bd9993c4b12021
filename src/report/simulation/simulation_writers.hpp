#pragma once

#include <string>
#include <vector>

#include "qerr/report/simulation_report.hpp"

namespace qerr {

/// A signal of the report and what it is called.
struct NamedSignal {
  const SimulatedSignal& signal;
  std::string filter;  ///< "position" before any
  std::string coordinate, unit;
};

/// All of them, in the order in which every format writes them. They live as long as the report.
std::vector<NamedSignal> signals_of(const SimulationReport&);

std::string simulation_table(const SimulationReport&);

}  // namespace qerr
