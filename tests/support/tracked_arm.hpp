#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/simulate/log.hpp"
#include "support/random_chain.hpp"

namespace qerr::testing {

/// A rotation by Rodrigues' formula, independent of the library's kinematics.
inline Eigen::Matrix3d rotation(const Eigen::Vector3d& z, double angle) {
  Eigen::Matrix3d k;
  k << 0, -z.z(), z.y(), z.z(), 0, -z.x(), -z.y(), z.x(), 0;
  return Eigen::Matrix3d::Identity() + std::sin(angle) * k + (1 - std::cos(angle)) * k * k;
}

/// An open chain of revolute joints: origin and axis of each joint in the previous link.
struct Arm {
  std::vector<Eigen::Vector3d> place, axis;
  Eigen::Vector3d tool;

  std::size_t size() const { return place.size(); }

  Eigen::Vector3d tip(const Eigen::VectorXd& q) const {
    Eigen::Vector3d p = tool;
    for (std::size_t i = size(); i-- > 0;)
      p = place[i] + rotation(axis[i], q[static_cast<Eigen::Index>(i)]) * p;
    return p;
  }

  OperationalModel model(const std::vector<double>& resolution) const {
    OperationalModel m;
    m.chain.base = "base";
    m.chain.tip = "tip";
    const auto n = static_cast<Eigen::Index>(size());
    m.transmission.coupling = Eigen::MatrixXd::Identity(n, n);
    for (std::size_t i = 0; i < size(); ++i) {
      ChainJoint joint;
      joint.name = "j" + std::to_string(i + 1);
      joint.origin.translate(place[i]);
      joint.axis = axis[i];
      joint.coordinate = i;
      m.chain.joints.push_back(joint);
      m.chain.independent.push_back({joint.name, JointType::revolute, {}});
      m.transmission.encoders.push_back({resolution[i], Rounding::nearest, true, 1});
    }
    m.chain.tip_offset.translate(tool);
    m.coordinates = {Coordinate::x, Coordinate::y, Coordinate::z};
    return m;
  }
};

/// Axes near z, y, y, x, y, x with small misalignments, links of a few decimetres.
inline Arm random_arm(Dice& dice, std::size_t joints) {
  const std::array<Eigen::Vector3d, 6> usual{Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY(),
                                             Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitX(),
                                             Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitX()};
  Arm arm;
  for (std::size_t i = 0; i < joints; ++i) {
    arm.axis.push_back((usual[i] + 0.1 * dice.direction()).normalized());
    const double up = dice.between(0.05, 0.4), across = dice.between(-0.1, 0.1);
    arm.place.emplace_back(dice.between(0.05, 0.4), across, up);
  }
  arm.tool = {dice.between(0.1, 0.3), dice.between(-0.1, 0.1), dice.between(0.05, 0.2)};
  return arm;
}

inline double gaussian(Dice& dice) {
  const double radius = std::sqrt(-2 * std::log(dice.between(1e-12, 1)));
  return radius * std::cos(2 * std::numbers::pi * dice.between(0, 1));
}

/// The record: true joint angles, and the encoders' errors.
struct Record {
  Eigen::ArrayXd time;        ///< empty: a table
  Eigen::MatrixXd joints;     ///< true, joints x rows
  Eigen::MatrixXd additions;  ///< errors of the encoders' readings
  bool with_references = false;
};

/// Random poses over the joints' ranges.
inline Record poses(Dice& dice, std::size_t joints, Eigen::Index rows) {
  Record r;
  r.joints.resize(static_cast<Eigen::Index>(joints), rows);
  for (double& q : r.joints.reshaped()) q = dice.between(-1.5, 1.5);
  r.additions.setZero(r.joints.rows(), rows);
  return r;
}

/// Sums of sines of a few tenths of a radian, many counts per sample.
inline Record motion(Dice& dice, std::size_t joints, Eigen::Index rows) {
  Record r;
  r.time = Eigen::ArrayXd::LinSpaced(rows, 0, 0.01 * static_cast<double>(rows - 1));
  r.joints.setZero(static_cast<Eigen::Index>(joints), rows);
  for (Eigen::Index j = 0; j < r.joints.rows(); ++j) {
    r.joints.row(j).setConstant(dice.between(-0.5, 0.5));
    for (int i = 0; i < 3; ++i) {
      const double phase = dice.between(0, 6.28), rate = 2 * std::numbers::pi * dice.between(0.05, 0.4),
                   size = dice.between(0.2, 0.6);
      r.joints.row(j) += (size * (rate * r.time + phase).sin()).matrix().transpose();
    }
  }
  r.additions.setZero(r.joints.rows(), rows);
  return r;
}

inline LogColumn column(LogSignal signal, std::size_t index, int decimals) {
  LogColumn c;
  c.signal = signal;
  c.index = index;
  c.text = {decimals, decimals, 12};
  return c;
}

/// The log of the actual arm; `seen` gives the tracker's measurement of the tip.
inline Log log_of(
    Dice& dice, const Arm& built, const Record& r, const std::vector<double>& resolution,
    double tracker_noise,
    const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& seen = [](const Eigen::Vector3d& p) {
      return p;
    }) {
  Log log;
  const Eigen::Index rows = r.joints.cols(), joints = r.joints.rows();
  if (r.time.size() > 0) log.columns.push_back(column(LogSignal::time, 0, 3));
  for (Eigen::Index j = 0; j < joints; ++j)
    log.columns.push_back(column(LogSignal::counts, static_cast<std::size_t>(j), 0));
  if (r.with_references)
    for (Eigen::Index j = 0; j < joints; ++j)
      log.columns.push_back(column(LogSignal::reference, static_cast<std::size_t>(j), 9));
  for (std::size_t i = 0; i < 3; ++i) log.columns.push_back(column(LogSignal::tip, i, 9));
  log.rows = static_cast<std::uint64_t>(rows);
  log.values.resize(rows, static_cast<Eigen::Index>(log.columns.size()));
  for (Eigen::Index k = 0; k < rows; ++k) {
    Eigen::Index at = 0;
    if (r.time.size() > 0) log.values(k, at++) = r.time[k];
    for (Eigen::Index j = 0; j < joints; ++j)
      log.values(k, at++) =
          std::floor((r.joints(j, k) + r.additions(j, k)) / resolution[static_cast<std::size_t>(j)] + 0.5);
    if (r.with_references)
      for (Eigen::Index j = 0; j < joints; ++j)
        log.values(k, at++) =
            r.joints(j, k) + 0.05 * resolution[static_cast<std::size_t>(j)] * gaussian(dice);
    const Eigen::Vector3d tip = seen(built.tip(r.joints.col(k)));
    for (Eigen::Index i = 0; i < 3; ++i) log.values(k, at++) = tip[i] + tracker_noise * gaussian(dice);
  }
  return log;
}

}  // namespace qerr::testing
