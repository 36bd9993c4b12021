#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "qerr/report/simulation_report.hpp"
#include "qerr/report/write.hpp"
#include "report/rows.hpp"
#include "report/text_table.hpp"

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

/// Why IPQN at the centre of the motion misses the sigma of some signals, and of which.
struct IpqnDeviation {
  std::string why, signals;
};

/// The signals whose sigma IPQN misses by more than 5 %, grouped by the factor that deviates most from 1.
std::vector<IpqnDeviation> ipqn_deviations(const SimulationReport&);

/// The rows of the estimates with a tracking error: label, encoder error, tracking error, its peak, total.
TableRows tracking_cells(const SimulationReport&);

/// The factors that lead from IPQN to the simulated sigma of each signal, with a header.
TableRows factor_cells(const SimulationReport&);

RowsOf<Ladder> rows(Of<Ladder>);
RowsOf<NamedSignal> rows(Of<NamedSignal>);

/// A cut-off and what it costs along the motion: root mean squares of the vector of the position's
/// coordinates [m/s^derivative].
struct CutoffChoice {
  double cutoff = 0;    ///< [Hz]
  double noise = 0;     ///< by the encoders
  double tracking = 0;  ///< by the filter
  double total = 0;     ///< of both, with their correlation where effects cause one
};

/// Cut-offs in equal ratios, rounded to four digits [Hz].
std::vector<double> cutoffs_between(double from, double to, std::size_t count);

/// @pre the report has `cutoffs`, and x, y or z is among the coordinates
std::vector<CutoffChoice> cutoff_choices(const SimulationReport&);

/// Index of the least total.
std::size_t best_of(const std::vector<CutoffChoice>&);

/// Unit of the errors.
std::string cutoff_unit(const SimulationReport&);

/// Error against speed of each joint's estimates, and the ranking.
std::string estimator_figures(const SimulationReport&);

/// `rad/s` or `m/s`.
std::string speed_unit(const SimulationReport&, const EstimatedVelocity&);

/// Amplitude spectral density over frequency: Welch's mean of the periodograms of half-overlapping sections
/// with Hann's window, one-sided: the mean square of the values about their mean is the integral of its
/// square.
/// @param rate  of the values [Hz]
/// @returns frequency [Hz] and density [unit of the values / sqrt(Hz)]; empty for fewer than 32 values
std::vector<std::pair<double, double>> amplitude_density(const std::vector<double>& values, double rate);

}  // namespace qerr
