#pragma once

#include <initializer_list>
#include <string_view>
#include <vector>

#include "effect/term.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

// Common parts of effects of the form amplitude * sin(order * shaft angle + phase).
Parameter periodic_amplitude();
Parameter periodic_phase();
Parameter periodic_shaft();
Action periodic_action(const Effect&, const Encoder&, std::uint64_t seed);
/// Whether it is a sine of its shaft's angle.
bool is_periodic(const EffectKind&);
/// Whether a periodic error's angle is the joint's, which nothing behind the clock displaces.
bool refers_to_joint(const Effect&);
std::optional<Share> periodic_share(const Effect&, const Encoder&, const Usage&);

/// Amplitude and phase of c0 sin(angle) + c1 cos(angle).
void fill_periodic(Effect&, const Eigen::VectorXd& coefficients);

/// Terms of these orders of the encoder's shaft and, behind a gear, of the joint: those of which the record
/// covers more than a tenth of a period.
std::vector<Term> periodic_terms(const RecordSignals&, std::initializer_list<double> encoder_orders,
                                 std::initializer_list<double> joint_orders);

/// Effects with the same error: a periodic error of the reference, an unmeasured load, the subdivision error
/// of an encoder with one period per revolution.
std::vector<Twin> periodic_twins();

/// Table over one period of the shaft.
TableShape periodic_table();

/// Whether the encoder's signal has one period per revolution of its shaft, as a resolver's.
bool has_one_period(const Encoder&);

}  // namespace qerr
