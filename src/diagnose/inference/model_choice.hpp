#pragma once

#include <optional>

#include "diagnose/inference/explanation.hpp"

namespace qerr {

// Criteria by which explanations of a record are compared. The thresholds are conventions, chosen on
// generated logs (tests/hidden); they are in log-likelihood unless stated.

inline constexpr double worth_trying = 8;       ///< log-likelihood that one Newton step promises
inline constexpr double worth_a_term = 3;       ///< in the Bayesian criterion
inline constexpr double worth_unnamed = 10;     ///< the same: what has no name must be clearly better
inline constexpr double worth_comparing = 0.5;  ///< of what a chosen term promised, by another in its place
inline constexpr double indistinguishable_loss = 6;  ///< log-likelihood that an alternative loses at most
inline constexpr double similar_loss = 40;    ///< the same, of one that explains nearly as much variance
inline constexpr double similar_part = 0.96;  ///< the part of it

/// The Bayesian criterion: log-likelihood less half a logarithm of the readings for each number that was
/// fitted, both by the number of independent readings.
double bayes(const Explanation&, const Evidence&);

/// The p-value of a model with a term against the one without it: of the likelihood ratio, less what
/// correlated errors make of it.
double p_value(const Explanation& without, const Explanation& with, std::size_t term);

/// Root mean square about its mean of what a term adds; of an offset, the offset itself [rad or m].
double size_of(const Explanation&, std::size_t term);

/// Mean square of the residual that a model leaves [rad^2 or m^2].
double mean_square_residual(const Explanation&, const Evidence&);

Explanation with_term(Explanation, Term);
Explanation without_term(Explanation, std::size_t term);
Explanation with_term_at(const Explanation&, std::size_t term, Term instead);

/// The same cause, whatever its size.
bool same_cause(const Effect&, const Effect&);

/// The same cause, whatever its size and its course in time: drifts of all time constants, steps at any
/// moment.
bool same_but_for_time(const Effect&, const Effect&);
bool has(const Explanation&, const Effect&);

/// The model with its last term's shape (an order, a time, a frequency) where the likelihood is largest.
Explanation refined(Explanation, const Evidence&);

/// A whole order in place of a last term's free one, where the record lets it be.
Explanation settled(Explanation, const Evidence&);

}  // namespace qerr
