#pragma once

#include "contestant.hpp"

namespace qerr::bench {

/// jacobian(), operational_error() and covariance() of single configurations, with the peers' statistics.
Contestant qerr_scalar();

/// workspace() of qerr as `qerr analyze` calls it, on one thread: more than the job requires.
Contestant qerr_workspace();

}  // namespace qerr::bench
