#pragma once

#include <charconv>
#include <string>

#include "qerr/core/error.hpp"
#include "qerr/filter/family.hpp"

namespace qerr {

// One line per member of this folder; src/filter/family.cpp lists them.
FilterFamily first_order_family();
FilterFamily butterworth_family();

/// A number for a message, 12 digits at most.
std::string figure(double value);

/// The whole number `key` of a design, `fallback` where absent.
/// @throws Error (input; key) unless it is whole and in [least, most]
int whole_number(const FilterDesign&, const std::string& key, int fallback, int least, int most);

/// The cut-off of a design [Hz].
/// @throws Error (input; key `cutoff`) unless 0 < cutoff < sample_rate/2
double checked_cutoff(const FilterDesign&);

}  // namespace qerr
