#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/core/parameter.hpp"

namespace qerr {

/// A row of the list of effects: what a real robot adds to the ideal model, with the parameters of the spec.
struct EffectKind {
  std::string_view name;
  std::string_view summary;
  std::vector<Parameter> parameters;
};

/// All effects that a spec can name, in the order of `qerr list effects`.
const std::vector<EffectKind>& effect_kinds();

/// One effect of a spec, its values checked and in SI units.
struct Effect {
  std::string type;
  std::string joint;  ///< "" for an effect of the whole robot
  std::map<std::string, double> numbers;
  std::map<std::string, std::string> choices;
};

}  // namespace qerr
