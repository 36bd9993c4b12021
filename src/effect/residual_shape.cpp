#include "qerr/effect/residual_shape.hpp"

namespace qerr {

std::string_view name(Shape s) {
  switch (s) {
    case Shape::step:
      return "step";
    case Shape::hysteresis:
      return "hysteresis";
    case Shape::exponential:
      return "exponential";
    case Shape::line:
      return "line";
    case Shape::order:
      return "order";
    case Shape::bump:
      return "bump";
    case Shape::by_count:
      return "by_count";
    case Shape::noise:
      return "noise";
    case Shape::unknown:
      return "unknown";
  }
  return "";
}

}  // namespace qerr
