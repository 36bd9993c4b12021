#include "diagnose/inference/tip/tip_term.hpp"

#include <algorithm>
#include <cmath>

#include "qerr/effect/effect_kind.hpp"

namespace qerr {

namespace {

/// Any unit vector across a direction.
Eigen::Vector3d across(const Eigen::Vector3d& z) { return z.unitOrthogonal(); }

}  // namespace

TipPose TipEstimate::pose(const TipEvidence& e, Eigen::Index row) const {
  const auto count = static_cast<Eigen::Index>(chain.joints.size());
  const Eigen::VectorXd q = e.joints.col(row) - e.to_joints * additions.col(row);
  TipPose p{Eigen::Matrix3Xd(3, count), Eigen::Matrix3Xd(3, count), {}, {}, {}, {}, {}, {}};
  Eigen::Isometry3d frame = base;
  for (Eigen::Index j = 0; j < count; ++j) {
    const ChainJoint& joint = chain.joints[static_cast<std::size_t>(j)];
    const double motion = joint.multiplier * q[static_cast<Eigen::Index>(joint.coordinate)] + joint.offset;
    p.motion.push_back(motion);
    p.parent.push_back(frame.linear() * joint.parent_axes);
    frame = frame * joint.origin;
    p.origin.col(j) = frame.translation();
    p.axis.col(j) = frame.linear() * joint.axis;
    if (joint.prismatic)
      frame.translate(motion * joint.axis);
    else
      frame.rotate(Eigen::AngleAxisd(motion, joint.axis));
  }
  frame = frame * chain.tip_offset;
  p.tool = frame.linear();
  p.tip = frame * tool;
  Eigen::MatrixXd columns(3, count);
  for (Eigen::Index j = 0; j < count; ++j) {
    const Eigen::Vector3d axis = p.axis.col(j), arm = p.tip - p.origin.col(j);
    columns.col(j) = chain.joints[static_cast<std::size_t>(j)].prismatic ? axis : axis.cross(arm);
  }
  p.joints = to_independent(chain, columns);
  p.encoders = p.joints * e.to_joints;
  return p;
}

Eigen::Index TipTerm::size() const {
  switch (kind) {
    case Kind::encoder:
      return term.size();
    case Kind::geometry:
      return 1;
    case Kind::tilt:
    case Kind::axis:
      return 2;
    case Kind::base:
      return 6;
    case Kind::tool:
      return 3;
  }
  return 0;
}

Eigen::Matrix3Xd TipTerm::at(const TipPose& p, Eigen::Index row) const {
  const auto place = static_cast<Eigen::Index>(where);
  Eigen::Matrix3Xd columns(3, size());
  switch (kind) {
    case Kind::encoder:
      columns = p.encoders.col(place) * term.columns.row(row).matrix();
      break;
    case Kind::geometry:
      // The true joint is displaced from the model's: estimate - true is minus the displacement.
      columns = -p.parent[where] * direction;
      break;
    case Kind::tilt:
    case Kind::axis: {
      // Across the axis in the frame before the joint, so that the tilt does not rotate with the joint.
      const Eigen::Matrix3d& frame = p.parent[where];
      const Eigen::Vector3d axis = p.axis.col(place), arm = p.tip - p.origin.col(place);
      const Eigen::Vector3d u = frame * across(frame.transpose() * axis);
      const auto displaced = [&](const Eigen::Vector3d& about) -> Eigen::Vector3d {
        if (kind == Kind::tilt) return about.cross(arm);
        if (slides) return p.motion[where] * about.cross(axis);
        // There and, after the joint, back: R(a + da, q) = T R(a, q) T^-1.
        return (about - Eigen::AngleAxisd(p.motion[where], axis) * about).cross(arm);
      };
      columns << -displaced(u), -displaced(axis.cross(u));
      break;
    }
    case Kind::base:
      columns.leftCols<3>() = -Eigen::Matrix3d::Identity();
      for (Eigen::Index i = 0; i < 3; ++i) columns.col(3 + i) = -Eigen::Vector3d::Unit(i).cross(p.tip);
      break;
    case Kind::tool:
      columns = -p.tool;
      break;
  }
  return columns;
}

Evidence corrected_evidence(const TipEvidence& e, const TipEstimate& estimate, std::size_t encoder) {
  Evidence own = e.encoders[encoder];
  own.path -= estimate.additions.row(static_cast<Eigen::Index>(encoder)).transpose().array();
  return own;
}

std::vector<TipTerm> tip_terms(const TipEvidence& e, const TipEstimate& estimate) {
  std::vector<TipTerm> terms;
  const Chain& chain = estimate.chain;
  for (std::size_t j = 0; j < chain.joints.size(); ++j) {
    const std::string& name = chain.joints[j].name;
    if (std::none_of(chain.independent.begin(), chain.independent.end(),
                     [&](const IndependentJoint& i) { return i.name == name; }))
      continue;  // a mimic joint has no effects of its own
    for (const EffectKind& kind : effect_kinds())
      if (kind.displacements)
        for (Term& t : kind.displacements(name)) {
          const Eigen::Vector3d direction = displacement_direction(t.effect);
          terms.push_back({TipTerm::Kind::geometry, std::move(t), j, direction});
        }
  }
  for (std::size_t i = 0; i < e.encoders.size(); ++i)
    if (e.judged(i))
      for (Term& t : named_terms(corrected_evidence(e, estimate, i)))
        if (!t.of_reference)  // without a reference at the joint, the encoder's own path drives no play
          terms.push_back({TipTerm::Kind::encoder, std::move(t), i});
  return terms;
}

std::vector<TipTerm> tilt_terms(const Chain& chain) {
  std::vector<TipTerm> terms;
  for (std::size_t j = 0; j < chain.joints.size(); ++j)
    for (const TipTerm::Kind kind : {TipTerm::Kind::tilt, TipTerm::Kind::axis}) {
      if (kind == TipTerm::Kind::tilt && (j == 0 || chain.joints[j].prismatic)) continue;
      TipTerm t{kind, {}, j};
      t.slides = chain.joints[j].prismatic;
      t.term.effect.joint = chain.independent[chain.joints[j].coordinate].name;
      t.term.fill = [](Effect& x, const Eigen::VectorXd& c) { x.numbers["amplitude"] = c.norm(); };
      t.term.unnamed = "the axis of the joint is askew";
      terms.push_back(std::move(t));
    }
  return terms;
}

void tilt(ChainJoint& joint, TipTerm::Kind kind, const Eigen::Vector2d& angles) {
  const Eigen::Matrix3d frame = joint.origin.linear();
  const Eigen::Vector3d axis = frame * joint.axis,
                        u = joint.parent_axes * across(joint.parent_axes.transpose() * axis);
  const Eigen::Vector3d about = angles[0] * u + angles[1] * axis.cross(u);
  if (about.norm() == 0) return;
  const Eigen::AngleAxisd turn(about.norm(), about.normalized());
  if (kind == TipTerm::Kind::axis)
    joint.axis = frame.transpose() * (turn * axis);
  else
    joint.origin.linear() = turn * frame;
}

void update_columns(TipTerm& t, const Eigen::VectorXd& c, const TipEvidence& e, const TipEstimate& estimate) {
  if (t.kind != TipTerm::Kind::encoder) return;
  const Evidence own = corrected_evidence(e, estimate, t.where);
  const Effect& effect = t.term.effect;
  if (t.term.hysteresis) {
    if (c[0] > own.step()) t.term.columns = t.term.hysteresis(own.measured, c[0]);
  } else if (t.term.step) {
    return;  // independent of the path
  } else if (t.term.reshaped) {
    t.term = t.term.reshaped(own, t.term, t.term.shape);
  } else {
    for (Term& fresh : named_terms(own))
      if (fresh.effect.type == effect.type && fresh.effect.choices == effect.choices &&
          fresh.effect.number_or("order", 0) == effect.number_or("order", 0) &&
          fresh.effect.number_or("time_constant", 0) == effect.number_or("time_constant", 0))
        t.term.columns = std::move(fresh.columns);
  }
}

}  // namespace qerr
