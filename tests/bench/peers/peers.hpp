#pragma once

#include "contestant.hpp"

/// The other libraries. Each is a separate shared library that exports this one function: inline functions
/// that it compiles with its own flags must not replace the same functions elsewhere.
#define QERR_PEER __attribute__((visibility("default")))

namespace qerr::bench {

QERR_PEER Contestant kdl();
QERR_PEER Contestant kdl_tuned();
QERR_PEER Contestant rbdl();
QERR_PEER Contestant pinocchio_peer();

}  // namespace qerr::bench
