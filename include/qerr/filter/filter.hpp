#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <optional>
#include <vector>

#include "qerr/core/double_double.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

/// A section of order one or two in w = (1 - z^-1)/(1 + z^-1): (b0 + b1 w + b2 w^2)/(a0 + a1 w + a2 w^2).
///
/// z = 1 is w = 0, and w is (T/2) d/dt for slow signals, so that slow poles keep their relative accuracy at
/// any ratio of cut-off to sample rate. The section is stable if and only if a0, a1 and, for second order, a2
/// have the same sign. First order: a2 = b2 = 0. The numerator's order is at most that of the denominator.
/// Coefficients are double-double, so that those of a section in z^-1 are converted exactly (section_in_w).
struct Section {
  std::array<DoubleDouble, 3> b{};
  std::array<DoubleDouble, 3> a{};
  bool operator==(const Section&) const = default;
};

/// The section (b0 + b1 q + b2 q^2)/(a0 + a1 q + a2 q^2), q = z^-1, in w: c0 + c1 q + c2 q^2 is
/// [(c0 + c1 + c2) + 2 (c0 - c2) w + (c0 - c1 + c2) w^2]/(1 + w)^2, exact where the bits of c0, c1, c2 span
/// fewer than 106 places, else with a relative error of 2^-100.
///
/// With a2 = b2 = 0 the section is of first order. Stability is not checked.
Section section_in_w(const std::array<double, 3>& b, const std::array<double, 3>& a);

/// Bounds of ||H_specified - H|| of a filter that was not specified by its sections [1/s^derivative].
struct Deviation {
  double h2 = 0;
  double l1 = 0;
};

/// A digital filter, H = gain * taps * product of the sections [1/s^derivative].
///
/// All functions below assume a stable filter, which the families and `filter_from_coefficients` guarantee.
struct Filter {
  std::vector<Section> sections;
  DoubleDouble gain = 1;
  double sample_rate = 0;               ///< [Hz]
  int derivative = 0;                   ///< that the output estimates; sets the unit
  std::vector<DoubleDouble> taps = {};  ///< h_k/gain of a filter without poles (sections are then empty)
  Deviation deviation = {};             ///< due to factoring a user's coefficients
  bool designed = false;                ///< by a family, with rounded coefficients; else they are exact
  /// Unit of the gain that a control law states; empty: 1/s^derivative.
  std::optional<Dimension> unit = {};
};

/// H(e^{j 2 pi f / sample_rate}), with full relative accuracy for tiny f, too, where derivatives vanish as
/// (j 2 pi f)^d.
/// @param frequency_hz  any frequency [Hz]; H is periodic in it with the sample rate
std::complex<double> response(const Filter&, double frequency_hz);

/// H(1), the gain for constant input [1/s^derivative].
double dc_gain(const Filter&);

/// Whether coefficients that state neither a derivative nor a unit pass constants with a gain other than 1: a
/// control law perhaps, in any case no estimate of the input.
bool has_unknown_unit(const Filter&);

/// Of the output for an input of this dimension; `none` where it is unknown.
Dimension output_dimension(const Dimension& input, const Filter&);

/// Group delay at 0 Hz [s]: -d arg H / d omega, the limit there for filters that vanish at 0 Hz.
///
/// (T/2) sum (a1/a0 - b1/b0) over the sections, without zeros at w = 0: d pure differences delay by d T/2.
double group_delay(const Filter&);

/// Largest pole modulus |z| in the z plane; 0 for FIR. Below 1 for every filter that qerr builds.
double poles_max_modulus(const Filter&);

/// h_0 .. h_{count-1} [1/s^derivative], in double-double.
/// @param every  above 1 only h_0, h_every, h_2every, ..., in double precision: for slow filters
std::vector<double> impulse_response(const Filter&, std::size_t count, std::size_t every = 1);

}  // namespace qerr
