#pragma once

#include "lanes/lanes.hpp"
#include "lanes/select_kernels.hpp"

// For kernel sources (lane_*.cpp) only: CMakeLists.txt defines the macros.

namespace qerr::lanes {
namespace {

/// The instruction set that this translation unit is compiled for, and its vector of doubles.
constexpr InstructionSet compiled_set = InstructionSet::QERR_INSTRUCTION_SET;
using CompiledLanes = Lanes<QERR_LANES>;

}  // namespace
}  // namespace qerr::lanes
