#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <vector>

#include "diagnose/record/evidence.hpp"
#include "effect/term.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/effect/effect.hpp"
#include "qerr/simulate/log.hpp"

namespace qerr {

/// Readings and path of an encoder in time [s, rad or m and their rate].
struct ReadPath {
  Eigen::ArrayXd time, measured, position, velocity;
};

/// Record of a tracked tip: its positions, and the best known joint positions (by the joint's reference where
/// there is one, else by its encoder).
struct TipEvidence {
  bool ordered = true;             ///< the rows follow each other in time
  std::vector<Eigen::Index> axes;  ///< tracked coordinates: 0 x, 1 y, 2 z
  Eigen::MatrixXd tip;             ///< tracked coordinates x rows [m]
  Eigen::MatrixXd joints;          ///< independent joints x rows [rad or m]
  Eigen::VectorXd joint_noise;     ///< of the joints' references, 0 without one [rad or m]
  Eigen::MatrixXd to_joints;       ///< joints x encoders: the coupling, 0 in rows of joints with a reference
  Eigen::MatrixXd
      delayed;  ///< the same, with the coupling of encoders that have 0 only: a late tip delays all joints
  std::vector<Evidence> encoders;  ///< path, speed, direction and load of every encoder, as read
  double noise = 0;                ///< of the tracker, per coordinate; 0: unknown [m]
  double log_resolution = 0;       ///< rounding step of the logged coordinates [m]
  /// Standard deviation of the mean of the rows of a pose, by their scatter, per coordinate; 0: poses are not
  /// repeated [m].
  double repeat_noise = 0;
  std::vector<Eigen::Index> row_of_log;  ///< the first of every row
  /// Paths of the encoders also beyond the rows: a late reading is of an instant near by, and a play is where
  /// the motion before has left it.
  std::shared_ptr<const std::vector<ReadPath>> paths;
  std::vector<Eigen::Index> row_of_path;

  Eigen::Index rows() const { return tip.cols(); }
  bool judged(std::size_t encoder) const {  ///< whether the tip is the only truth of this encoder
    return !to_joints.col(static_cast<Eigen::Index>(encoder)).isZero();
  }
};

/// The evidence at the tip, with equal rows merged (see `independent`), and of long records every n-th of
/// these.
/// @param present  effects that the spec already has: they displace the joints of the model
/// @returns empty if the log lacks the tip or a joint
std::optional<TipEvidence> tip_evidence(const OperationalModel&, const std::vector<Effect>& present,
                                        const Log&, unsigned threads);

/// The evidence of these rows alone.
TipEvidence with_rows(TipEvidence, const std::vector<Eigen::Index>& rows);

/// Kinematic quantities at one row, from which the columns of terms are computed. Base frame, [m].
struct TipPose {
  Eigen::Matrix3Xd origin, axis;  ///< of the moving joints
  std::vector<double> motion;     ///< of each from its zero [rad or m]
  std::vector<Eigen::Matrix3d>
      before;            ///< axes of the frame before each joint of the chain, and before the tip
  Eigen::Matrix3d tool;  ///< axes of the tip
  Eigen::Vector3d tip;
  Eigen::Matrix3Xd encoders;  ///< tip per encoder, J C: only of joints without a reference
  Eigen::Matrix3Xd joints;    ///< tip per independent joint, J
};

/// The present estimate of the robot: link dimensions, corrections of the encoders, and the tracker's frames.
struct TipEstimate {
  Chain chain;
  Eigen::MatrixXd additions;  ///< encoders x rows: additions of the causes to the readings [rad or m]
  Eigen::MatrixXd delay;      ///< age of the readings, like the additions, which contain what it adds [s]
  Eigen::MatrixXd slope;      ///< of what the delay adds, by the delay, like the additions [rad/s or m/s]
  Eigen::Isometry3d base = Eigen::Isometry3d::Identity();  ///< of the robot in the tracker's frame
  Eigen::Vector3d tool = Eigen::Vector3d::Zero();  ///< the target, in the frame of the model's tip [m]

  TipPose pose(const TipEvidence&, Eigen::Index row) const;
};

/// The most polynomials of time that describe a displacement of the tracker along a coordinate.
inline constexpr Eigen::Index most_polynomials = 9;

/// Displacement of the tip at one pose by a unit of each coefficient of a term [m].
using TipColumns = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3 * most_polynomials>;

/// A cause of an error of the tip.
struct TipTerm {
  enum class Kind {
    encoder,     ///< adds to the reading of an encoder
    geometry,    ///< displaces a joint's origin
    frame_tilt,  ///< rotates a joint's frame with all that follows: <origin rpy> of the URDF
    axis_tilt,   ///< rotates a joint's axis alone, what follows stays in the zero pose: <axis> of the URDF
    base,        ///< displaces and rotates the robot in the tracker's frame
    tool,        ///< displaces the target in the tip's frame
    late,        ///< delays the readings of an encoder, or of all (`where`: the number of encoders), in
                 ///< each row by the term's column [s]
    tracker,     ///< displaces the tracker in time, by each of the term's columns along each direction
    target,      ///< displaces what is tracked in time, like `tracker`, along the axes of the tip
    growth       ///< displaces a joint's origin in time, like `tracker`
  };
  Kind kind = Kind::encoder;
  Term term;  ///< its effect and fill; of an encoder, a delay, the tracker or its target the columns too
  /// Encoder or moving joint; of geometry and growth, OriginPlace::link; of the tracker and its target the
  /// row from which they are displaced, 0: always.
  std::size_t where = 0;
  /// Unit vectors in the frame before that joint, one a coefficient: along which geometry displaces, about
  /// which a tilt rotates. They are those of the nominal robot, so that coefficients keep their meaning in a
  /// fit. Of the tracker and its target in the base's axes and the tip's.
  Eigen::Matrix3Xd directions = {};
  bool slides = false;      ///< of an axis: its joint is prismatic
  bool kinematic() const {  ///< whether it depends on the pose alone
    return kind == Kind::encoder ? term.constant : kind != Kind::late && !of_record();
  }
  /// Whether it is of this record alone: no model of the machine has it.
  bool of_record() const { return kind == Kind::tracker || kind == Kind::target || kind == Kind::growth; }
  /// Of a late term: whether it delays this encoder.
  bool delays(std::size_t encoder, const TipEvidence& e) const {
    return kind == Kind::late && (where == e.encoders.size() || where == encoder);
  }
  Eigen::Index size() const;

  /// estimate - true at the tip per unit of the coefficients, 3 x size.
  TipColumns at(const TipPose&, const TipEvidence&, const TipEstimate&, Eigen::Index row) const;
};

/// What the delay of an encoder adds to its reading at a row, by the path [rad or m].
double added_by_delay(const TipEvidence&, std::size_t encoder, Eigen::Index row, double delay);

/// The slope of `added_by_delay` by the delay: encoders x rows [rad/s or m/s]. Empty for rows without
/// an order in time: no clock is judged from them.
Eigen::MatrixXd slopes_by_delay(const TipEvidence&, const Eigen::MatrixXd& delay);

/// Candidates of the catalogue: dimensions, and errors of encoders whose joints have no reference; errors of
/// the clock of all readings, which are those of the tracker's stamps, too.
std::vector<TipTerm> tip_terms(const TipEvidence&, const TipEstimate&);

/// Tilts of every joint's frame, but of the first, which is one of the tracker's frame, and of every joint's
/// axis, each about two directions across the axis of the nominal robot. They are not in the catalogue.
std::vector<TipTerm> tilt_terms(const Chain&);

/// Applies a tilt to its joint.
/// @param rotation  rotation vector in the frame before the joint [rad]
void tilt(ChainJoint&, TipTerm::Kind, const Eigen::Vector3d& rotation);

/// An encoder's evidence with the estimated additions subtracted from its path.
Evidence corrected_evidence(const TipEvidence&, const TipEstimate&, std::size_t encoder);

/// Recomputes the columns along the estimated path; of a hysteresis, at the size found.
void update_columns(TipTerm&, const Eigen::VectorXd& coefficients, const TipEvidence&, const TipEstimate&);

}  // namespace qerr
