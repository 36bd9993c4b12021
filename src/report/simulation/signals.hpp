#pragma once

#include <string>
#include <utility>
#include <vector>

#include "qerr/report/simulation_report.hpp"
#include "report/rows.hpp"

namespace qerr {

/// A signal of the report and its names. Borrows the signal from the report.
struct NamedSignal {
  const SimulatedSignal& signal;
  std::string filter;  ///< "position" for the unfiltered signal
  std::string coordinate, unit;
  std::string shown_unit;  ///< in tables and pages: "" of a control law that states none

  const SimulatedSignal& operator*() const { return signal; }  ///< for rows that name its members
};

/// All signals, in the order of every format. Valid as long as the report.
std::vector<NamedSignal> signals_of(const SimulationReport&);

/// `velocity x`.
std::string label_of(const NamedSignal&);

/// The sigma of a constant error is rounding of the computation: below 1e-6 of the IPQN sigma it counts as 0.
bool is_constant(const SimulatedSignal&);

/// Roll or yaw in a motion through the gimbal lock.
bool is_unbounded(const SimulatedSignal&);

/// Why IPQN at the centre of the motion misses the sigma of some signals, and of which.
struct IpqnDeviation {
  std::string why, signals;
};

/// The signals whose sigma IPQN misses by more than 5 %, grouped by the factor that deviates most from 1.
std::vector<IpqnDeviation> ipqn_deviations(const SimulationReport&);

/// Of each estimate with a tracking error: label, encoder error, tracking error, its peak, total.
std::vector<std::vector<std::string>> tracking_cells(const SimulationReport&);

/// The factors that lead from IPQN to the simulated sigma of each signal, with a header.
std::vector<std::vector<std::string>> factor_cells(const SimulationReport&);

RowsOf<Ladder> rows(Of<Ladder>);
RowsOf<NamedSignal> rows(Of<NamedSignal>);

}  // namespace qerr
