#pragma once

#include "qerr/report/analysis.hpp"
#include "report/json_header.hpp"

namespace qerr {

/// The members that the JSON of an analysis and of its check begin with: those of every report, and
/// `configurations`.
Json analysis_header(const Analysis&, const char* command);

/// Values of the independent joints by their names.
Json by_joint(const Spec&, const Eigen::VectorXd& values);

/// `{"lower", "upper", "gap", "at"}`; null is unbounded.
Json proven_json(const Spec&, const ProvenMaximum&);

}  // namespace qerr
