#pragma once

#include <string>
#include <vector>

#include "diagnose/search/error_model.hpp"

namespace qerr {

/// Families of chosen names that what is left over contradicts:
///
/// - an order that does not stand out against its neighbours: of an order whose amplitude varies along the
///   path, or of wandering, whole orders are no more than others are (F test of the decrease of the sum of
///   squares against that of orders beside it, error rate 0.1 %);
/// - an order above 1 of which less than half a period is seen, beside an uncatalogued shape or an order of
///   which less than a period is: together they are one curve, as other orders make it, too;
/// - a name that explains little without the uncatalogued shapes: it only corrects these;
/// - a name that is smaller than a fifth of an uncatalogued shape whose form is guessed.
std::vector<std::string> without_contrast(const ErrorModel&, const Choice&);

}  // namespace qerr
