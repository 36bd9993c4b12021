#pragma once

#include <cmath>
#include <string>

#include "qerr/filter/filter.hpp"
#include "support/measured.hpp"

namespace qerr::testing {

/// The part of a double-double below the last bit of its upper word, in units of that bit: 2 + (-0.5 .. 0.5).
inline double low_digits(const DoubleDouble& x) {
  return x.hi == 0 ? 2 : 2 + std::ldexp(x.lo, 52 - std::ilogb(x.hi));
}

/// All coefficients of a filter with eight digits, and sums of them with weights that tell one from the
/// other.
/// @param most_sections  of more than these the sums alone
inline void expect_coefficients(const Measured& measured, const std::string& name, const Filter& filter,
                                std::size_t most_sections) {
  measured.expect(name + ",sections", static_cast<double>(filter.sections.size()));
  measured.expect(name + ",taps", static_cast<double>(filter.taps.size()));
  measured.expect(name + ",designed", filter.designed);
  measured.expect(name + ",gain", filter.gain.hi);
  double weight = 1, size = 0, place = 0;
  const auto add = [&](const DoubleDouble& c) {
    weight = weight > 100 ? 1.37 : weight * 1.37;
    size += std::abs(c.hi);
    place += weight * (std::abs(c.hi) + 0.5 * c.hi);
  };
  for (std::size_t i = 0; i < filter.sections.size(); ++i) {
    const Section& s = filter.sections[i];
    for (const auto* list : {&s.b, &s.a})
      for (std::size_t k = 0; k < 3; ++k) {
        const DoubleDouble& c = (*list)[k];
        add(c);
        if (c == 0 || c == 1 || filter.sections.size() > most_sections) continue;
        measured.expect(
            name + ',' + (list == &s.b ? 'b' : 'a') + std::to_string(k) + " of section " + std::to_string(i),
            c.hi);
      }
  }
  for (const DoubleDouble& c : filter.taps) add(c);
  measured.expect(name + ",sum of sizes", size);
  measured.expect(name + ",weighted sum", place);
}

/// The digits 17 to 24 of all coefficients, of a filter whose parameters are exact.
inline void expect_low_digits(const Measured& measured, const std::string& name, const Filter& filter) {
  double low = low_digits(filter.gain), weight = 1;
  const auto add = [&](const DoubleDouble& c) {
    weight = weight > 100 ? 1.37 : weight * 1.37;
    low += weight * low_digits(c);
  };
  for (const Section& s : filter.sections)
    for (const auto* list : {&s.b, &s.a})
      for (const DoubleDouble& c : *list) add(c);
  for (const DoubleDouble& c : filter.taps) add(c);
  measured.expect(name + ",low digits", low);
}

}  // namespace qerr::testing
