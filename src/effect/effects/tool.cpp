#include "effect/effects/effects.hpp"

namespace qerr {

/// Found in a tracked tip: where the tracked point lies, from the model's tip, in the axes of the last link.
EffectKind tool_effect() {
  const auto metres = [](std::string_view name, std::string_view meaning) {
    return Parameter{.name = name, .dimension = dimension::length, .meaning = meaning};
  };
  return {
      .name = "tool",
      .summary = "the tracked point is not the model's tip",
      .parameters = {metres("x", "along x of the tip's link"), metres("y", "along y"),
                     metres("z", "along z")},
      .remedy = {false,
                 "no pose tells a longer tool from a target beside its tip: measure the tool, or where the "
                 "target is held, and correct the URDF or robot.tool (the radius of a robot of one joint)"},
      .spec_remedy = "write robot: {tool: {xyz: [...]}}"};
}

}  // namespace qerr
