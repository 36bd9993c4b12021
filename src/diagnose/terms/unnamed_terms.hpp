#pragma once

#include <Eigen/Core>

#include "effect/term.hpp"

namespace qerr {

// Terms of errors that no effect of the catalogue makes: an explanation may need them, a spec cannot state
// them.

/// Any function of the position, or of time: piecewise linear between evenly spaced knots.
Term position_table_term(const RecordSignals&, Eigen::Index knots);
Term time_table_term(const RecordSignals&, Eigen::Index knots);

/// A vibration of one frequency [Hz].
Term vibration_term(const RecordSignals&, double frequency);

}  // namespace qerr
