#pragma once

#include <string_view>
#include <vector>

namespace qerr {

/// The instructions that the batched kernels are compiled for, from the least to the most lanes.
enum class InstructionSet {
  portable,  ///< what every processor of the architecture has: 2 lanes
  avx2,      ///< x86-64 with AVX2 and fused multiply-add: 4 lanes
  avx512     ///< x86-64 with AVX-512 (F, DQ, VL, BW): 8 lanes
};

std::string_view name_of(InstructionSet);

/// Those that this processor has and this build holds, the widest last.
const std::vector<InstructionSet>& available_instruction_sets();

/// The widest one, or the one that the environment variable QERR_INSTRUCTION_SET names.
///
/// Sets differ in their last bits (a fused multiply-add rounds once): on one machine the same version gives
/// the same bytes, between machines 12 digits.
/// @throws Error (usage) when the variable names none that can be had
InstructionSet instruction_set();

}  // namespace qerr
