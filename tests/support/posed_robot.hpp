#pragma once

#include <cstdint>
#include <utility>

#include "diagnose/inference/tip/tip_evidence.hpp"
#include "support/tracked_arm.hpp"

namespace qerr::testing {

/// A robot with revolute and sliding joints, mimics, and a coupling; random poses of its joints.
struct PosedRobot {
  OperationalModel model;
  TipEvidence evidence;
  TipEstimate estimate;

  PosedRobot(Dice& dice, std::size_t joints, Eigen::Index rows, std::uint64_t kind) {
    model.chain = make_chain(random_robot(dice, {joints}), "", "");
    const auto n = static_cast<Eigen::Index>(model.chain.independent.size());
    model.transmission = random_transmission(dice, model.chain, 1e-4, 1e-3, kind % 2 == 1);
    evidence.ordered = false;
    evidence.axes = {0, 1, 2};
    if (kind % 5 == 4) evidence.axes = {0, 2};
    evidence.joints.resize(n, rows);
    for (Eigen::Index k = 0; k < rows; ++k) evidence.joints.col(k) = random_configuration(dice, model.chain);
    evidence.joint_noise = Eigen::VectorXd::Zero(n);
    evidence.to_joints = model.transmission.coupling.dense();
    if (kind % 3 == 2) {  // the first joint has a reference
      evidence.to_joints.row(0).setZero();
      evidence.joint_noise[0] = 2e-5;
    }
    evidence.delayed = evidence.to_joints;
    const Eigen::MatrixXd read = model.transmission.coupling.inverse() * evidence.joints;
    for (Eigen::Index i = 0; i < n; ++i) {
      Evidence e;
      e.joint = model.chain.independent[static_cast<std::size_t>(i)].name;
      e.encoder = model.transmission.encoders[static_cast<std::size_t>(i)];
      e.ordered = false;
      e.time = Eigen::ArrayXd::LinSpaced(rows, 0, static_cast<double>(rows - 1));
      e.path = e.reference = e.measured = read.row(i).transpose().array();
      e.velocity = e.direction = Eigen::ArrayXd::Zero(rows);
      e.noise = sigma(e.encoder);
      evidence.encoders.push_back(std::move(e));
    }
    evidence.tip.setZero(static_cast<Eigen::Index>(evidence.axes.size()), rows);
    estimate.chain = model.chain;
    estimate.additions.setZero(n, rows);
    estimate.base = dice.frame(0.2);
    estimate.tool = 0.1 * dice.direction();
  }

  Eigen::Vector3d tip(const TipEstimate& t, Eigen::Index row) const {
    const Eigen::VectorXd q = evidence.joints.col(row) - evidence.to_joints * t.additions.col(row);
    return t.base * (forward_kinematics(t.chain, q) * t.tool);
  }
};

}  // namespace qerr::testing
