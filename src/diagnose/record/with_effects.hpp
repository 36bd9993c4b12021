#pragma once

#include <vector>

#include "diagnose/record/evidence.hpp"
#include "qerr/effect/effect.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

/// The evidence for a model that already has effects: reference and path displaced by what they add.
///
/// Every effect's action (`EffectKind`) runs along the path, stage by stage as in a simulation: clocks read
/// the path at their instant, an effect with a `replay` uses the recorded signals, a decoder acts on whole
/// counts, and an error of the reference is subtracted. Random effects only increase `random_sigma`. Effects
/// of the load need the effort column.
Evidence with_effects(Evidence, const std::vector<Effect>&);

/// Whether the encoder's clock, by these effects, reads the path within the record at some instants: what it
/// was before and behind is not known.
Eigen::Array<bool, Eigen::Dynamic, 1> reads_within(const Evidence& record, const std::vector<Effect>&,
                                                   const Eigen::ArrayXd& time);

/// The rows at which it does, if there are any.
Evidence within_record(Evidence, const std::vector<Effect>&);

/// Part of the rows that a clock must read within the record: one that does not is a guess of a search.
inline constexpr double least_part_within = 0.9;

/// The joint's path where the clocks of its encoder read it: what drives a play at the joint [rad or m].
/// Borrows the evidence.
class PathAsRead {
 public:
  PathAsRead(const Evidence&, const std::vector<Effect>& clocks);
  double operator()(Eigen::Index row);
  Eigen::ArrayXd of_all_rows();

  /// Where the clocks read at a time [s].
  double instant(double time) const;

 private:
  const Evidence& e_;
  std::vector<Action> clocks_;
  Eigen::Index before_ = 0;  ///< row of the last instant
};

/// Whether one term displaces the position on which another depends: it acts before it. A shape without a
/// name is one of the position as it is read, behind all that displaces others.
bool displaces(const Term&, const Term& other);
/// Whether it displaces what stands behind it by more than a search notices: clock, link, play and a wrong
/// ratio.
bool displaces(const Term&);

/// Adds to encoders that depend on several joints (coupling) what the other joints' clocks, links and gears
/// add.
void add_coupled_effects(std::vector<Evidence>&, const Transmission&, const std::vector<Effect>&);

}  // namespace qerr
