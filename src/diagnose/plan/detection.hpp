#pragma once

namespace qerr {

/// What one reading tells, on average over where in a count the joint is.
struct ReadingInformation {
  double position = 0;  ///< Fisher's, of the position [1/count^2]
  double scatter = 0;   ///< the same of log sigma
};

/// Of a quantized reading beside a reference with white noise.
/// @param noise  of the reference, standard deviation [counts], > 0
ReadingInformation reading_information(double noise);

}  // namespace qerr
