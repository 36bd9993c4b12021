#pragma once

#include <optional>

#include "diagnose/inference/explanation.hpp"

namespace qerr {

// Criteria by which explanations of a record are compared. The thresholds are conventions, in log-likelihood
// unless stated.

inline constexpr double worth_trying = 8;       ///< least gain of one Newton step
inline constexpr double worth_a_term = 3;       ///< least improvement of `bayes`
inline constexpr double worth_unnamed = 10;     ///< additional improvement required of an unnamed term
inline constexpr double worth_comparing = 0.5;  ///< least gain of an alternative over that of the chosen term
inline constexpr double indistinguishable_loss = 6;  ///< largest loss of an alternative
inline constexpr double similar_loss = 40;    ///< largest loss of an alternative that retains `similar_part`
inline constexpr double similar_part = 0.96;  ///< minimum fraction of explained variance retained

/// Schwarz's criterion: log-likelihood - (k/2) log n for k fitted numbers and n independent readings, with
/// the log-likelihood per independent reading.
double bayes(const Explanation&, const Evidence&);

/// p-value of a term by the likelihood ratio of the models with and without it: chi-squared, divided by the
/// variance inflation due to correlated residuals.
double p_value(const Explanation& without, const Explanation& with, std::size_t term);

/// Standard deviation of a term's addition over the rows; of an offset, its magnitude [rad or m].
double size_of(const Explanation&, std::size_t term);

/// Mean square residual of a model [rad^2 or m^2].
double mean_square_residual(const Explanation&, const Evidence&);

Explanation with_term(Explanation, Term);
Explanation without_term(Explanation, std::size_t term);
Explanation with_term_at(const Explanation&, std::size_t term, Term instead);

/// Whether two effects are the same cause, regardless of their size.
bool same_cause(const Effect&, const Effect&);

/// Whether two effects are the same cause, regardless of size, time constant and time.
bool same_but_for_time(const Effect&, const Effect&);
bool has(const Explanation&, const Effect&);

/// The model with its last term's shape (an order, a time, a frequency) where the likelihood is largest.
Explanation refined(Explanation, const Evidence&);

/// Replaces the free order of the last term by an integer one, if the loss of likelihood is small.
Explanation settled(Explanation, const Evidence&);

}  // namespace qerr
