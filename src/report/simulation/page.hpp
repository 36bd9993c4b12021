#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "report/simulation/signals.hpp"

namespace qerr {

/// The parts of the page of a simulation, as markup; each "" if there is nothing to show.

/// Simulated sigmas as parts of the predicted ones.
std::string prediction_figure(const SimulationReport&);

/// The error of a signal in time inside its bounds.
/// @param trace      of the signal's filter
/// @param intervals  of the line
std::string error_figure(const NamedSignal&, const ErrorTrace& trace, const std::vector<double>& error,
                         std::size_t intervals);

/// Spectral density of the error beside that of white errors of the theory's sigma behind the filter.
/// @param position  the same coordinate without a filter
/// @param filter    null: none
std::string spectrum_figure(const NamedSignal&, const SimulatedSignal& position, const Filter* filter,
                            const ErrorTrace& trace, const std::vector<double>& error, std::size_t intervals);

/// The path of the tip in three views, its ends marked; of a robot whose tip moves by translation.
std::string path_figures(const SimulationReport&);

/// Errors over the cut-off, with --cutoffs.
std::string cutoff_figures(const SimulationReport&);

/// Amplitude spectral density over frequency: Welch's mean of the periodograms of half-overlapping sections
/// with Hann's window, one-sided: the mean square of the values about their mean is the integral of its
/// square.
/// @param rate  of the values [Hz]
/// @returns frequency [Hz] and density [unit of the values / sqrt(Hz)]; empty for fewer than 32 values
std::vector<std::pair<double, double>> amplitude_density(const std::vector<double>& values, double rate);

}  // namespace qerr
