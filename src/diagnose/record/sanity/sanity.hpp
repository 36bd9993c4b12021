#pragma once

#include <string>
#include <vector>

#include "diagnose/record/evidence.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/diagnose/diagnosis.hpp"
#include "qerr/filter/filter.hpp"
#include "qerr/simulate/log.hpp"

namespace qerr {

/// The log after repair of the faults that need no model fit, and these faults.
struct Sanity {
  /// Repaired: counters without overflow, counts with the right decoding, even stamps in place of rounded
  /// ones; without the rows of a stuck sensor, those in which a sensor is held, single readings far off, and
  /// without columns that carry no information (a constant reference, a "load" that is the control error).
  Log log;
  OperationalModel model;       ///< with the encoders' resolutions as observed in the log
  std::vector<Effect> present;  ///< of the spec, without those that the repair has undone
  /// Per encoder: standard deviation of a finer quantizer ahead of the model's [rad or m]; 0: none.
  std::vector<double> rounding_sigma;
  std::vector<double>
      rms_before;             ///< of measured - reference as recorded, per encoder [rad or m]; 0: unknown
  std::vector<Cause> causes;  ///< identified
  std::vector<AlternativeCause> alternatives;  ///< that apply if `instead_of` is identified at their joint
  std::vector<Unidentified> unexplained;
  std::vector<DataFinding> data;
  std::vector<double>
      reference_grid;  ///< per encoder: step of a reference that is coarser [rad or m]; 0: none
  std::string spoilt;  ///< why the log as it stands misleads, and the remedy; "": it does not
  std::vector<std::string> warnings;
  std::string cannot_judge;  ///< the reason if the log has no reference, and what to record; else ""
};

/// Finds the faults of a record that need no model fit, and repairs the log.
///
/// - `rollover`: counts jump by one modulus at the end of a counter; measured - reference has levels n M;
/// - `decoding`: counts are a simple ratio (or -1) times the reference;
/// - `log_rounding`: positions recorded more coarsely than the encoder resolves, in the file or the counter;
/// - `missed_counts`: three losses of whole counts and more;
/// - columns in another unit than their header says, exchanged columns, single readings far off;
/// - sensors that are read less often than the log has rows, references on a grid coarser than the encoder;
/// - stuck sensors, references that are constant, coarser than the encoder or unrelated to it;
/// - trackers whose columns are exchanged, in another unit, or no positions of the tip;
/// - stamps that are rounded, duplicate, uneven, or have gaps;
/// - efforts in amperes, with another sign, or with friction in them become loads by the masses of the URDF;
/// - `controller_droop`: an effort proportional to measured - reference that is not a load;
/// - velocities of another unit, sign or zero, that wrap, or that are constant;
/// - of joints without a reference: single readings far off, leaps, holds, stuck bits, ripple at constant
/// speed;
/// - `filter_mismatch`: JOINT.velocity is the output of another filter than the spec's;
/// - `timing_jitter`: JOINT.velocity follows the recorded intervals, not a constant one.
///
/// Tables without time and logs of a tracked tip are valid; checks that need time or a joint's reference are
/// skipped for them.
/// @param filters  of the spec; those of the first derivative are compared with JOINT.velocity
/// @param log      with its values
/// @param present  effects of the spec: they are undone in the log, and only differences, such as another
///   modulus, are reported
Sanity check_sanity(const OperationalModel&, const std::vector<Filter>& filters, Log log,
                    const std::vector<Effect>& present = {});

/// The evidence of some encoders of a repaired log, with the remaining effects of the spec in the paths.
/// @param encoders  of couplings, those of all joints that share an encoder
std::vector<Evidence> evidence(const Sanity&, const std::vector<std::size_t>& encoders, unsigned threads = 0);

}  // namespace qerr
