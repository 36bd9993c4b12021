#pragma once

#include <Eigen/Core>

#include "diagnose/record/sampling.hpp"
#include "effect/term.hpp"

namespace qerr {

// Terms of errors that no effect of the catalogue makes: an explanation may need them, a spec cannot state
// them. `effect.numbers` holds the figures of their shape.

/// Any function of the position, or of time: piecewise linear between evenly spaced knots.
Term position_table_term(const RecordSignals&, Eigen::Index knots);
Term time_table_term(const RecordSignals&, Eigen::Index knots);

/// A polynomial of the position, or of time, with its straight line: Legendre polynomials over the range.
/// @param degree  2 and more: a straight line of the position alone is a scale error
Term position_polynomial_term(const RecordSignals&, int degree);
Term time_polynomial_term(const RecordSignals&, int degree);

/// In proportion to time.
extern const char* const next_of_rate;  ///< what to inspect where an error has a rate in time
Term steady_change_term(const RecordSignals&);

/// A sine of the joint's angle [periods per rad or m * 2 pi] whose amplitude is proportional to the effort.
Term loaded_order_term(const RecordSignals&, double order);

/// The path of another joint: a coupling that the model does not have.
Term coupling_term(const RecordSignals&, const std::string& other, const Eigen::ArrayXd& path);

/// A vibration of one frequency [Hz].
Term vibration_term(const RecordSignals&, double frequency);

/// A constant that begins at one time [s].
Term offset_step_term(const RecordSignals&, double time);

/// 1 - exp(-(t - time)/time_constant) from `time` on: a creep after an event [s].
Term transition_term(const RecordSignals&, double time, double time_constant);

/// From 0 to 1 in proportion to time within `duration` from `time` on: a slip that takes a while [s].
Term ramp_term(const RecordSignals&, double time, double duration);

/// a x (1 - exp(-t/time_constant)) + b (1 - exp(-t/time_constant)): a scale that grows while the machine
/// warms up, about an unknown fixed point [s].
Term growth_term(const RecordSignals&, double time_constant);

/// a x T + b T with the recorded temperature T.
Term thermal_growth_term(const RecordSignals&);

/// A Gaussian bump at one position [rad or m].
Term bump_term(const RecordSignals&, double position, double width);

/// The magnitude of the velocity: an error that does not change its sign with the direction.
Term speed_term(const RecordSignals&);

/// Hysteresis of friction (Dahl 1968): dz/dx = (1 - z sgn(dx))/travel, which saturates at the direction of
/// motion over a travel [rad or m] after each reversal. Motion within the noise of the path is none.
/// @param path  of the record's rows, as the encoder reads it
Term friction_term(const Sampling&, const Eigen::ArrayXd& path, double travel);

/// State that follows the direction of motion (0 at rest) with a time constant [s]: what decays after each
/// stop, as creep and viscoelasticity do.
Term relaxation_term(const Sampling&, double time_constant);

/// What begins at each reversal and decays with a time constant [s]; one column for reversals towards either
/// side.
Term settling_term(const Sampling&, double time_constant);

/// Displacements of the edges that repeat every four counts, by their deviation from the mean: the states of
/// a quadrature disc. Columns: edges that alternate, and the two components of period four.
Term state_pattern_term(const Sampling&);

}  // namespace qerr
