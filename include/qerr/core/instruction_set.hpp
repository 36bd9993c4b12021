#pragma once

#include <string_view>
#include <vector>

namespace qerr {

/// Instruction sets that the batched kernels are compiled for, in ascending order of vector width.
enum class InstructionSet {
  portable,  ///< the baseline of the architecture: 2 doubles per vector
  avx2,      ///< x86-64 with AVX2 and fused multiply-add: 4
  avx512     ///< x86-64 with AVX-512 (F, DQ, VL, BW): 8
};

std::string_view name_of(InstructionSet);

/// Instruction sets that this processor supports and this build contains, in ascending order of width.
const std::vector<InstructionSet>& available_instruction_sets();

/// The widest available set, or the one named by the environment variable QERR_INSTRUCTION_SET.
///
/// Results of different sets differ by rounding (a fused multiply-add rounds once): one version gives the
/// same bytes on one machine, and 12 equal digits on different ones.
/// @throws Error (usage) when the variable names a set that is not available
InstructionSet instruction_set();

}  // namespace qerr
