#include "effect/effects/effects.hpp"

namespace qerr {

EffectKind velocity_fault_effect() {
  return {.name = "velocity_fault",
          .summary = "the recorded velocity contradicts the motion of its joint",
          .stage = Stage::log,
          .parameters = {{.name = "fault",
                          .kind = Kind::choice,
                          .meaning = "what is wrong with it",
                          .choices = "unit|sign|factor|offset|wrap|constant|unrelated|noise"},
                         {.name = "factor", .meaning = "its values over those of the motion"},
                         {.name = "offset", .dimension = dimension::angular_speed, .meaning = "at rest"},
                         {.name = "interval",
                          .dimension = dimension::angular_speed,
                          .meaning = "by which it wraps around"},
                         {.name = "sigma", .dimension = dimension::angular_speed, .meaning = "of its noise"}},
          .remedy = {false, "correct the column as said of the record, or leave it out"},
          .spec_remedy = "correct the log's column JOINT.velocity, or leave it out"};
}

}  // namespace qerr
