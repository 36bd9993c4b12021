#pragma once

#include <string>

#include "qerr/report/analysis.hpp"
#include "qerr/report/write.hpp"

/// Proven maxima in the report of `analyze`.
namespace qerr {

/// Adds the proofs that are asked for or required, and a warning of gaps that are wider than the one asked
/// for.
/// @throws Error (input; key `requirements`) for a required figure that is not known
void add_proofs(Analysis&, const ProofRequest&, unsigned threads);

/// The section of the table: sampled, reached and proven maximum of each figure; "" without proofs.
std::string proof_table(const Analysis&, const Style&);

}  // namespace qerr
