#pragma once

#include <optional>

#include "diagnose/inference/explanation.hpp"

namespace qerr {

// The term with the largest score test statistic over a range of orders, frequencies or times.

/// Number of hypotheses of a scan, for the Bonferroni correction of its p-value.
inline constexpr int scanned_hypotheses = 2000;

std::optional<Term> strongest_step(const Evidence&, const Explanation&);
std::optional<Term> strongest_order(const Evidence&, const Explanation&);
std::optional<Term> strongest_vibration(const Evidence&, const Explanation&);

/// Integer orders of either shaft within the search interval of a free order.
std::vector<Term> at_whole_orders(const Evidence&, const Term& free_order);

}  // namespace qerr
