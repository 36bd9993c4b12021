#pragma once

#include "contestant.hpp"

/// The libraries beside qerr. Each is a shared library of its own that shows this one function: what it
/// compiles with its own flags must not take the place of the same inline functions elsewhere.
#define QERR_PEER __attribute__((visibility("default")))

namespace qerr::bench {

QERR_PEER Contestant kdl();
QERR_PEER Contestant kdl_tuned();
QERR_PEER Contestant rbdl();
QERR_PEER Contestant pinocchio_peer();

}  // namespace qerr::bench
