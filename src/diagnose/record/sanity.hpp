#pragma once

#include <string>
#include <vector>

#include "diagnose/record/evidence.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/diagnose/diagnosis.hpp"
#include "qerr/filter/filter.hpp"
#include "qerr/simulate/log.hpp"

namespace qerr {

/// What a log shows before anything is fitted to it, and the log without it.
struct Sanity {
  /// Repaired: counters run on beyond their rollover, counts are read with the right decoding, stamps that
  /// were rounded are even again, rows of a sensor that was stuck are gone, and so are columns that say
  /// nothing (a reference that never moves, a "load" that is the servo error).
  Log log;
  OperationalModel model;       ///< with the encoders' resolutions as the log shows them
  std::vector<Effect> present;  ///< of the spec, without those that the repair has undone
  /// Per encoder: what a finer quantizer before the one of the model scatters the position by, its standard
  /// deviation [rad or m]; 0 where there is none.
  std::vector<double> rounding_sigma;
  std::vector<double>
      rms_before;             ///< of measured - reference as recorded, per encoder [rad or m]; 0: not known
  std::vector<Cause> causes;  ///< by name
  std::vector<AlternativeCause> alternatives;  ///< that stand once `instead_of` is named at their joint
  std::vector<Unnamed> unexplained;
  std::vector<std::string> warnings;
  std::string cannot_judge;  ///< why the log says nothing about positions, and what would; else ""
};

/// The faults of a record that need no fit: cheap, and often the whole answer.
///
/// - `rollover`: counts jump by one modulus where a counter ends, measured - reference has levels n M;
/// - `decoding`: counts are a simple ratio (or -1) times what the reference asks for;
/// - `log_rounding`: positions on a grid coarser than the encoder's, in the file or in the counter;
/// - stuck sensors, references that never move or are coarser than the encoder;
/// - stamps: rounded, coinciding, uneven, with gaps;
/// - `controller_droop`: an effort that is a multiple of measured - reference, and no load;
/// - `filter_mismatch`: JOINT.velocity is not what the spec's filter makes of the counts, but what another
///   one does; `timing_jitter`: it is what the stamps' differences make, not a constant interval.
///
/// Tables without time and logs of a tracked tip pass; what needs order or a joint's reference is left out.
/// @param filters  of the spec; those of the first derivative are held against JOINT.velocity
/// @param log      with its values
/// @param present  effects that the spec has: the log is repaired with them, and named is what differs from
///   them, such as another modulus
Sanity check_sanity(const OperationalModel&, const std::vector<Filter>& filters, const Log& log,
                    const std::vector<Effect>& present = {});

/// The evidence of a repaired log, along the paths that the effects left in the spec make of the motion.
std::vector<Evidence> evidence(const Sanity&, unsigned threads = 0);

}  // namespace qerr
