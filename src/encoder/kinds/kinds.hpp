#pragma once

#include "qerr/encoder/encoder.hpp"

/// The rows of `encoder_kinds()`. A new kind is one file in this folder, its line here and one in the list.
namespace qerr {

EncoderKind counts_per_rev_encoder();
EncoderKind lines_per_rev_encoder();
EncoderKind bits_encoder();
EncoderKind periods_per_rev_encoder();
EncoderKind resolution_encoder();

/// Upper limit of counts, lines and periods per revolution: a double still resolves their fractions.
inline constexpr double most_per_revolution = 1e15;

}  // namespace qerr
