#include "diagnose/verdict/record_advice.hpp"

#include <array>

namespace qerr {

namespace {

struct Advice {
  std::string_view one, other, record;
};

constexpr std::string_view any = "*";

/// The first row that fits, in either order.
constexpr std::array<Advice, 12> advices{{
    {"offset", "truncation",
     "an absolute datum: an index pulse or a stop whose position is known to a tenth of a count"},
    {"latency", "backlash", "reversals at two speeds or more, with a rest after each"},
    {"offset", "backlash", "motion in both directions, with reversals"},
    {"scale", "clock_drift", "a way back late in the record: scale fades with the angle, the clock goes on"},
    {"latency", "clock_drift", "a longer record, with the same speeds at its start and at its end"},
    {"noise", "timing_jitter", "a section at rest and sections at several speeds"},
    {"subdivision_error", any, "the raw sine and cosine of the encoder (their Lissajous figure)"},
    {"transmission_error", "reference_error",
     "the same motion by a second reference, or with the reference turned on its shaft"},
    {"compliance", any, "the same motion with another payload, and faster"},
    {"drift", any, "a return to the start, and the temperature"},
    {"eccentricity", any, "several turns of the shaft, in both directions"},
    {"scale", any, "a wider range of the joint, several turns if it can"},
}};

bool fits(std::string_view pattern, std::string_view name) { return pattern == any || pattern == name; }

}  // namespace

std::string record_advice(std::string_view one, std::string_view other) {
  for (const Advice& a : advices)
    if ((fits(a.one, one) && fits(a.other, other)) || (fits(a.one, other) && fits(a.other, one)))
      return std::string(a.record);
  return "a richer motion: the whole range, several speeds, both directions, rests between";
}

}  // namespace qerr
