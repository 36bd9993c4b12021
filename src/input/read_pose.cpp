#include <cmath>

#include "input/read_sections.hpp"
#include "input/spec_format.hpp"

/// Reads the keys `robot.tool` and `robot.tracker` of a spec.
namespace qerr {

namespace {

Eigen::Vector3d read_three(const Object& o, std::string_view key, Dimension dimension) {
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  if (!o.has(key)) return v;
  const Field list = o.at(key);
  const std::vector<Field> items = read_list(list);
  if (items.size() != 3) throw Error(list.fault("needs three numbers", "write [0, 0, 0]"));
  for (Eigen::Index i = 0; i < 3; ++i)
    v[i] = read_number(items[static_cast<std::size_t>(i)], {.name = key, .dimension = dimension});
  return v;
}

}  // namespace

Eigen::Isometry3d read_pose(const Field& f) {
  const Object o(f, spec_format::pose());
  const Eigen::Vector3d rpy = read_three(o, "rpy", dimension::angle);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = read_three(o, "xyz", dimension::length);
  pose.linear() = (Eigen::AngleAxisd(rpy[2], Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(rpy[1], Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(rpy[0], Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  return pose;
}

Eigen::Vector3d roll_pitch_yaw(const Eigen::Matrix3d& r) {
  const double level = std::hypot(r(0, 0), r(1, 0));
  if (level < 1e-12) return {0, std::atan2(-r(2, 0), level), std::atan2(-r(0, 1), r(1, 1))};
  return {std::atan2(r(2, 1), r(2, 2)), std::atan2(-r(2, 0), level), std::atan2(r(1, 0), r(0, 0))};
}

}  // namespace qerr
