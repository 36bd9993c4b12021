#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "diagnose/search/error_model.hpp"

namespace qerr {

/// Looks in a residual for orders and loaded orders, lines in time, steps and bumps that the scanned ones do
/// not have, and adds them.
/// @param residual  one per sample [rad or m]
/// @returns whether there was any
bool scan_residual(const ErrorModel&, const Eigen::ArrayXd& residual, Scanned&);

/// Adds the events in time that a residual suggests.
/// @returns whether any were added
bool scan_events(const ErrorModel&, const Eigen::ArrayXd& residual, Scanned&);

/// Families of chosen terms, most of them names, that what is left over contradicts:
///
/// - an order that does not stand out against its neighbours: of an order whose amplitude varies along the
///   path, or of wandering, whole orders are no more than others are (F test of the decrease of the sum of
///   squares against that of orders beside it, error rate 0.1 %);
/// - an order above 1 of which less than half a period is seen, beside an uncatalogued shape or an order of
///   which less than a period is: together they are one curve, as other orders make it, too;
/// - an order beside another one that the record does not resolve from it, where all together
///   leave something;
/// - a name that explains little without the uncatalogued shapes: it only corrects these;
/// - a name that is smaller than a fifth of an uncatalogued shape whose form is guessed;
/// - a name that, beside a correlated remainder, explains as much where its columns are shifted in time;
/// - a reading ahead of time beside anything else that is left;
/// - any term that the recorded reference has as well, before it is smoothed.
std::vector<std::string> without_contrast(const ErrorModel&, const Choice&);

/// The family of the name that explains least, of those that a correlated remainder puts in doubt: more than
/// five times as much is left as it explains, which any column has in common with a shape that is not its
/// own; or, without the uncatalogued curves, it would be another by half of its size. Steps, and orders of
/// which a period is seen, are not in doubt: their shapes stand out. Others may stand once it has gone.
std::vector<std::string> outweighed(const ErrorModel&, const Choice&);

/// Families of the chosen terms that the quantizer alone would bring: the fit without the term, sent through
/// the quantizer along the same path with new noise, is analysed with it. Its decrease of the sum of squares
/// is compared with the mean decrease in nine such simulations (F test, error rate 1 %).
std::vector<std::string> brought_by_rounding(const ErrorModel&, const Choice&, std::uint64_t seed);

/// Rates of the chosen whole orders that the record does not tell from a number between two of them.
std::vector<Scanned::Rate> without_whole_number(const ErrorModel&, const Choice&);

}  // namespace qerr
