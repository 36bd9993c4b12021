#pragma once

namespace qerr {

// Criteria of a plan, in log-likelihood unless stated (conventions).

inline constexpr double worth_trying = 8;            ///< least gain of a term
inline constexpr double worth_a_term = 3;            ///< least improvement of Schwarz's criterion by a term
inline constexpr double worth_comparing = 0.5;       ///< squared correlation from which terms are compared
inline constexpr double indistinguishable_loss = 6;  ///< largest loss of an alternative
inline constexpr double similar_part = 0.96;         ///< part of the variance that an alternative reproduces
inline constexpr int scanned_hypotheses = 2000;      ///< times and orders that a scan compares

}  // namespace qerr
