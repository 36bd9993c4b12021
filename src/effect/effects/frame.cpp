#include "effect/effects/effects.hpp"

namespace qerr {

/// Found in a tracked tip: the rigid motion from the robot's base, as the spec has it, to the tracker's
/// frame.
EffectKind frame_effect() {
  const auto metres = [](std::string_view name, std::string_view meaning) {
    return Parameter{.name = name, .dimension = dimension::length, .meaning = meaning};
  };
  const auto angle = [](std::string_view name, std::string_view meaning) {
    return Parameter{.name = name, .dimension = dimension::angle, .meaning = meaning};
  };
  return {.name = "frame",
          .summary = "the tip is logged in a frame that is not the robot's base",
          .parameters = {metres("x", "displacement along x of the base"), metres("y", "along y"),
                         metres("z", "along z"), angle("rx", "rotation about x of the base"),
                         angle("ry", "about y"), angle("rz", "about z")},
          .remedy = {false,
                     "transform the log into the robot's base, or state the frame as robot.tracker; a first "
                     "joint that is displaced or askew looks the same: survey the tracker at the base"},
          .spec_remedy = "write robot: {tracker: {xyz: [...], rpy: [...]}}"};
}

}  // namespace qerr
