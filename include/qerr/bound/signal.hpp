#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/kinematics/chain.hpp"
#include "qerr/kinematics/coordinates.hpp"

namespace qerr {

struct OperationalModel;
struct SignalKind;
struct LoopsAt;  // src/bound/signals/signals.hpp

/// A quantity of the robot whose error is of interest.
struct Signal {
  std::string name;                           ///< in specs and reports: `x`, `xyz`, a joint's name
  std::string unit;                           ///< "m" or "rad"
  std::optional<Coordinate> coordinate = {};  ///< of the tip, or a length of three; empty: of `kind`
  const SignalKind* kind = nullptr;
  std::size_t index = 0;  ///< among the robot's signals of `kind`
};

/// Norms of the transfer functions from each independent error to a signal: of a row of numbers |c|, |c|, c.
struct SignalNorms {
  Eigen::RowVectorXd l1;  ///< sum |h_k|; infinite if unstable
  Eigen::RowVectorXd h2;  ///< sqrt(sum h_k^2)
  Eigen::RowVectorXd dc;  ///< sum h_k
};

/// A coordinate of the tip of a chain.
struct ChainCoordinate {
  const Chain* chain;  ///< of the model
  Coordinate coordinate;
};

/// A kind of signals beside the tip's coordinates, by its row c(q): an error dq of the independent joints
/// changes the signal by c dq, and a displaced origin of a joint does not change it. Every bound follows from
/// the row.
///
/// A row of a family: its file in src/bound/signals, and a line in list.inc there.
struct SignalKind {
  std::string_view group;    ///< stands for all of a robot's signals of this kind in `coordinates`
  std::string_view summary;  ///< for `qerr list coordinates`
  /// The robot's signals, without kind and index.
  std::vector<Signal> (*signals)(const OperationalModel&);
  /// c(q), one number for each independent joint [1, m/rad or rad/m].
  Eigen::RowVectorXd (*row)(const OperationalModel&, std::size_t index, const Eigen::VectorXd& q);
  /// Largest |signal(q + dq) - signal(q) - c(q) dq| for |dq| <= `worst_case` of each joint; infinite if none
  /// is known.
  double (*remainder)(const OperationalModel&, std::size_t index, const Eigen::VectorXd& q,
                      const Eigen::VectorXd& worst_case);
  bool constant = false;  ///< c is the same at all configurations
  bool joints = false;    ///< signal i is the coordinate of independent joint i: filters of joints pass it
  /// The norms of the transfer functions at q, of a signal that depends on the past of the errors, as in a
  /// closed loop. Its bounds follow from them, and no filter passes it. Null: c is all.
  /// @param moved  derivative of the independent joints with respect to each error
  /// @param loops  of the model's controllers, at q
  SignalNorms (*norms)(const OperationalModel&, std::size_t index, const Eigen::VectorXd& q,
                       const Eigen::MatrixXd& moved, const LoopsAt& loops) = nullptr;
  /// The coordinate that the signal is, of a chain with the model's independent joints. Null: none.
  ChainCoordinate (*of_chain)(const OperationalModel&, std::size_t index) = nullptr;
};

const std::vector<SignalKind>& signal_kinds();

/// The signals that a word in `coordinates` stands for, the tip's coordinates left out: of the group, or the
/// one of that name. Empty: none.
std::vector<Signal> find_signals(const OperationalModel&, std::string_view word);

/// Names of all signals of the kinds that a robot has.
std::vector<std::string> signal_names(const OperationalModel&);

/// The model whose only signal is a coordinate of a chain, that of a signal of the model: figures and proofs
/// of that coordinate are those of the signal.
/// @param signal  index into all_signals; its kind has of_chain
OperationalModel coordinate_model(OperationalModel, std::size_t signal);

/// A coordinate of the tip, or a length, as a signal.
Signal signal_of(Coordinate);

/// Whether a signal has transfer functions of its own in place of a row.
inline bool is_closed(const Signal& s) { return s.kind && s.kind->norms; }

inline bool is_length(const Signal& s) { return s.coordinate && is_length(*s.coordinate); }

}  // namespace qerr
