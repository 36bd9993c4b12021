#pragma once

#include <cmath>

namespace qerr {

/// What the effects of an encoder make of a reading by which a loop is closed, as far as that loop is not the
/// loop of a perfect reading with a bounded error beside it.
struct LoopReading {
  double delay = 0;     ///< of the reading [s]
  double factor = 1;    ///< reading over the joint's motion, without rounding
  double count = 1;     ///< steps of the reading over the encoder's resolution
  double excess = 0;    ///< half width of an error of the counted position, beside half a step [resolutions]
  double rounding = 0;  ///< half width of an error that the decoder adds [resolutions]
  double narrowest_state = 1;  ///< [resolutions]
  double play = 0;             ///< full width, of the joint [rad or m]
  bool behind_play = false;    ///< the encoder is on the side that is driven through the play
  double of_position = 0;      ///< half width of errors that depend on the position alone [rad or m]
  double slope = 0;            ///< largest |derivative| of these: by it the gain varies from place to place

  bool operator==(const LoopReading&) const = default;

  /// Half width of the reading's error that lasts at rest, of counts, their states and the play [rad or m].
  double half_width(double resolution) const {
    return resolution * (std::abs(count) * (0.5 + excess) + rounding) + 0.5 * std::abs(factor) * play;
  }
};

}  // namespace qerr
