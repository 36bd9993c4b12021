#pragma once

#include "diagnose/search/cause_search.hpp"
#include "diagnose/search/error_model.hpp"

namespace qerr {

/// Counts are lost in whole numbers: other chosen steps become uncatalogued ones.
void distinguish_steps(const ErrorModel&, Choice&);

/// What a choice says: its terms in descending order of the variance that each removes alone, their
/// alternatives, and what the record would have shown.
FoundCauses found_causes(const ErrorModel&, const Choice&);

}  // namespace qerr
