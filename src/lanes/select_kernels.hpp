#pragma once

#include "qerr/core/instruction_set.hpp"

// One dispatch for all kernels. A kernel source (lane_*.cpp) is compiled once per instruction set
// (CMakeLists.txt) and defines `compiled_kernels` of its table for that set; a new set is a line there, in
// InstructionSet, in the list of instruction_set.cpp and below.

namespace qerr {

/// The kernels of a table of function pointers, such as BoundKernels, as compiled for `set`.
template <class Table, InstructionSet set>
const Table& compiled_kernels();

/// The kernels of a table as compiled for a set that is known at run time.
/// @pre this build holds the set (`available_instruction_sets`)
template <class Table>
const Table& select_kernels(InstructionSet set) {
  switch (set) {
#if defined(__x86_64__)
    case InstructionSet::avx512:
      return compiled_kernels<Table, InstructionSet::avx512>();
    case InstructionSet::avx2:
      return compiled_kernels<Table, InstructionSet::avx2>();
#endif
    default:
      return compiled_kernels<Table, InstructionSet::portable>();
  }
}

}  // namespace qerr

// For kernel sources (lane_*.cpp) only: CMakeLists.txt defines the macros.
#ifdef QERR_LANES
#include "lanes/lanes.hpp"

namespace qerr::lanes {
namespace {

/// The instruction set that this translation unit is compiled for, and its vector of doubles.
constexpr InstructionSet compiled_set = InstructionSet::QERR_INSTRUCTION_SET;
using CompiledLanes = Lanes<QERR_LANES>;

}  // namespace
}  // namespace qerr::lanes
#endif
