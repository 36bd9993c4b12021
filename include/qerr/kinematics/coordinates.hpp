#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/kinematics/chain.hpp"
#include "qerr/kinematics/coordinates.hpp"

namespace qerr {

/// In whose axes x y z and rx ry rz are. The error is that of the tip in the base in both cases.
enum class CoordinateFrame { base, tip };

/// An operational coordinate of the tip.
enum class Coordinate { x, y, z, rx, ry, rz, roll, pitch, yaw, xyz, rxyz };

/// A row of the list of coordinates.
struct CoordinateInfo {
  Coordinate coordinate;
  std::string_view name;
  std::string_view unit;  ///< "m" or "rad"
  std::string_view summary;
};

const std::vector<CoordinateInfo>& coordinate_list();
const CoordinateInfo& info(Coordinate);
std::optional<Coordinate> find_coordinate(std::string_view name);

inline bool is_position(Coordinate c) { return c <= Coordinate::z; }
inline bool is_rotation_vector(Coordinate c) { return c >= Coordinate::rx && c <= Coordinate::rz; }
inline bool is_euler_angle(Coordinate c) { return c >= Coordinate::roll && c <= Coordinate::yaw; }
/// Whether it is the length of the vector of x y z or of rx ry rz.
inline bool is_length(Coordinate c) { return c >= Coordinate::xyz; }
/// x of xyz, rx of rxyz.
inline Coordinate first_component(Coordinate length) {
  return length == Coordinate::xyz ? Coordinate::x : Coordinate::rx;
}

/// cos(pitch) of R = Rz(yaw) Ry(pitch) Rx(roll): 0 at the gimbal lock.
double cosine_of_pitch(const Eigen::Matrix3d& rotation);

/// Rows of the chosen coordinates from a geometric Jacobian (6 x joints, linear rows first).
///
/// x y z and rx ry rz are its rows; with omega = E(roll, pitch, yaw)^-1 the rates are
/// roll' = (cos(yaw) wx + sin(yaw) wy)/cos(pitch), pitch' = -sin(yaw) wx + cos(yaw) wy, yaw' = sin(pitch)
/// roll' + wz. At the gimbal lock, cos(pitch) < gimbal_lock, their rows are infinite: roll and yaw are
/// unbounded there, and pitch, which falls to all sides of +-90 deg, has no rate. In the axes of the tip,
/// rows of x y z and rx ry rz are rotation^T times those of the Jacobian.
/// @pre no length
/// @returns coordinates x joints
Eigen::MatrixXd coordinate_rows(const std::vector<Coordinate>&, const Jacobian&,
                                const Eigen::Matrix3d& rotation, CoordinateFrame = CoordinateFrame::base);

}  // namespace qerr
