#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/core/parameter.hpp"
#include "qerr/encoder/encoder.hpp"

namespace qerr {

/// One effect of a spec, its values checked and in SI units.
struct Effect {
  std::string type;
  std::string joint;  ///< the independent joint it acts on
  std::map<std::string, double> numbers;
  std::map<std::string, std::string> choices;

  double number(const std::string& name) const {
    const auto found = numbers.find(name);
    return found == numbers.end() ? 0 : found->second;
  }
};

/// Where an effect acts on the way from the motion to the file, in the order in which the signal passes.
enum class Stage {
  clock,       ///< when the joint is read [s]
  link,        ///< between joint and gear [rad or m]
  gear,        ///< inside the gear [rad or m]
  disc,        ///< scale and disc of the encoder [rad or m on the joint side]
  line,        ///< within one line or signal period [rad or m on the joint side]
  comparator,  ///< just before the position becomes a count [rad or m on the joint side]
  decoder,     ///< on the count [counts]
  log,         ///< on what is written [rad or m]
  reference,   ///< on the better sensor that is written beside it [rad or m]
  kinematics   ///< on the robot itself; no signal passes here
};

/// What an effect may know of the moment at which it acts.
struct Moment {
  std::uint64_t index = 0;      ///< number of the sample
  double time = 0;              ///< [s]
  double joint = 0;             ///< true joint position [rad or m]
  double effort = 0;            ///< torque or force at the joint [N m or N]
  double temperature_rise = 0;  ///< since the start [K]
};

/// What an effect makes of the signal at its stage. May remember earlier samples: one action serves one run,
/// in order.
using Action = std::function<double(double signal, const Moment&)>;

/// How a joint is used: what effects of speed, load and range are multiplied with.
struct Usage {
  double largest_position = 0, rms_position = 0;  ///< from the joint's zero [rad or m]
  double largest_speed = 0, rms_speed = 0;        ///< [rad/s or m/s]
  double largest_effort = 0, rms_effort = 0;      ///< [N m or N]
  double duration = 0;                            ///< [s]
};

/// What an effect adds to the error of its joint, estimate - true [rad or m].
///
/// The worst case grows by |mean| + half_width, the variance by sigma^2. A Gaussian has no worst case; its
/// half_width is four sigma.
struct Share {
  double mean = 0, half_width = 0, sigma = 0;
};

/// A row of the list of effects: what a real robot adds to the ideal model.
///
/// `action` makes it for one run of a simulation from its parameters, the encoder it acts on and a seed;
/// `share` says what it adds to the bounds.
struct EffectKind {
  std::string_view name;
  std::string_view summary;
  std::string_view typical;  ///< usual size, and where that is known from
  Stage stage;
  std::vector<Parameter> parameters;
  Action (*action)(const Effect&, const Encoder&, std::uint64_t seed);
  Share (*share)(const Effect&, const Encoder&, const Usage&);
};

/// All effects that a spec can name, in the order of `qerr list effects`.
const std::vector<EffectKind>& effect_kinds();

/// @throws std::out_of_range for a name that no row has; specs are checked when they are read
const EffectKind& effect_kind(std::string_view name);

}  // namespace qerr
