#pragma once

#include <Eigen/Core>
#include <map>
#include <string>

#include "qerr/core/parameter.hpp"
#include "qerr/encoder/encoder.hpp"

namespace qerr {

/// One effect of a spec, its values checked and in SI units.
struct Effect {
  std::string type;
  std::string joint;  ///< the independent joint it acts on
  std::map<std::string, double> numbers;
  std::map<std::string, std::string> choices;

  /// Value of a parameter: the given one, else the default of the effect's row, else 0.
  /// @throws std::out_of_range for a name that is neither given nor a parameter of the row
  double number(const std::string& name) const;

  /// The given value of a parameter, else `otherwise`: also for effects whose row has no such parameter.
  double number_or(const std::string& name, double otherwise) const {
    const auto found = numbers.find(name);
    return found == numbers.end() ? otherwise : found->second;
  }
};

/// Whether any parameter of an effect is not zero.
bool has_size(const Effect&);

/// Wave number of a periodic effect: phase of its sine per joint coordinate, the order times the signed ratio
/// of its shaft (the encoder's, or the joint's by the choice `shaft`) [rad/rad or rad/m].
/// @returns 0 for an effect without an order
double wave_number(const Effect&, const Encoder&);

/// Unit vector along which an effect of stage `kinematics` displaces its joint's origin, by its choice `axis`
/// in the axes of the joint's parent link.
/// @throws std::out_of_range for an effect without that choice
Eigen::Vector3d displacement_direction(const Effect&);

}  // namespace qerr
