#include <cmath>
#include <limits>

#include "filter/norms/l1_norm.hpp"
#include "filter/norms/rational.hpp"
#include "qerr/core/error.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {
namespace {

constexpr double enough = 0x1p-70;  // relative radius, well below the rounding of the result to double

template <class T>
std::optional<Estimate> estimate(const Ball<T>& norm) {
  const double value = static_cast<double>(norm.mid());
  const auto error = (norm - Ball<T>(value)).largest();
  if (!std::isfinite(value) || !std::isfinite(error)) return std::nullopt;
  // Converting the radius rounds by 2^-53 of it.
  return Estimate{value, static_cast<double>(error) * (1 + 0x1p-50) + std::numeric_limits<double>::min()};
}

/// The norm in numbers of type T; empty unless its relative radius is at most `wanted`. Double-double
/// suffices for all families; a cascade of twelve equal poles 1e-9 from the unit circle needs 1024 bits.
template <class T>
std::optional<Estimate> estimate_in(const Filter& filter, double lift, double wanted) {
  const auto squared = squared_norm(rational<T>(filter, lift));
  if (!squared) return std::nullopt;
  // The gain last: its square may exceed the range of double.
  const Ball<T> norm = sqrt(*squared) * abs(Ball<T>::exactly(filter.gain));
  if (!(static_cast<double>(norm.rad()) <= wanted * static_cast<double>(norm.largest()))) return std::nullopt;
  return estimate(norm);
}

std::optional<Estimate> taps_norm(const Filter& filter) {
  Ball<DoubleDouble> total;
  for (const DoubleDouble& h : filter.taps) total += Ball<DoubleDouble>(h) * Ball<DoubleDouble>(h);
  return estimate(sqrt(total) * abs(Ball<DoubleDouble>(filter.gain)));
}

}  // namespace

Estimate h2_estimate(const Filter& filter) {
  std::optional<Estimate> e;
  if (filter.gain.hi != 0 && std::isfinite(filter.gain.hi)) {
    if (!filter.taps.empty()) e = taps_norm(filter);
    if (!e) e = estimate_in<DoubleDouble>(filter, 0, enough);
    if (!e) e = estimate_in<Binary1024>(filter, 0, enough);
    if (!e) e = estimate_in<Binary<4096>>(filter, 0, 1);
  }
  if (!e)
    throw Error(
        "", "the norms of the filter exceed the range of double precision",
        std::isfinite(filter.gain.hi) ? "a gain of " + shortest(filter.gain.hi) : "a gain above 1.8e308",
        "scale its coefficients, or bring cut-off and sample rate closer together");
  e->error += filter.deviation.h2 + design_rounding(filter) * e->value;
  return *e;
}

double lifted_norm(const Filter& filter, double lift) {
  // One digit suffices.
  std::optional<Estimate> e = estimate_in<DoubleDouble>(filter, lift, 0.1);
  if (!e) e = estimate_in<Binary1024>(filter, lift, 0.1);
  return e ? e->value + e->error : std::numeric_limits<double>::infinity();
}

double h2_norm(const Filter& filter) { return h2_estimate(filter).value; }

Norms norms(const Filter& filter) {
  const Estimate h2 = h2_estimate(filter);
  return {h2.value, h2.error, l1_norm(filter), dc_gain(filter)};
}

}  // namespace qerr
