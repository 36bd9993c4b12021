#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "qerr/report/simulation_report.hpp"
#include "qerr/report/write.hpp"

namespace qerr {

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

std::string cutoff_table(const SimulationReport&, const Style&);

}  // namespace qerr
