#pragma once

#include <initializer_list>
#include <string_view>
#include <vector>

#include "effect/term.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

// What effects of the form amplitude * sin(order * shaft angle + phase) share.
Parameter periodic_amplitude();
Parameter periodic_phase();
Parameter periodic_shaft();
Action periodic_action(const Effect&, const Encoder&, std::uint64_t seed);
std::optional<Share> periodic_share(const Effect&, const Encoder&, const Usage&);

/// Amplitude and phase of c0 sin(angle) + c1 cos(angle).
void fill_periodic(Effect&, const Eigen::VectorXd& coefficients);

/// Terms of these orders of the encoder's shaft and, behind a gear, of the joint: those of which the record
/// covers more than a tenth of a period.
std::vector<Term> periodic_terms(const RecordSignals&, std::initializer_list<double> encoder_orders,
                                 std::initializer_list<double> joint_orders);

/// What looks the same: an error of the reference's machine, an unknown load, a line of one period.
/// @param of_reference  what to record to distinguish it from an error of the reference
std::vector<Twin> periodic_twins(std::string_view of_reference = {});

/// A table of an effect that repeats with its shaft.
TableShape periodic_table();

/// Whether the encoder's signal has one period per revolution of its shaft, as a resolver's.
bool has_one_period(const Encoder&);

}  // namespace qerr
