#pragma once

#include <optional>

#include "diagnose/inference/explanation.hpp"

namespace qerr {

// What the scores of a model ask for most, over a whole range of orders, frequencies or moments.

/// Orders and moments that a scan tries: how many hypotheses its best one was chosen from.
inline constexpr int scanned_hypotheses = 2000;

std::optional<Term> strongest_step(const Evidence&, const Explanation&);
std::optional<Term> strongest_order(const Evidence&, const Explanation&);
std::optional<Term> strongest_vibration(const Evidence&, const Explanation&);

/// Whole numbers of periods per revolution of either shaft, where the record lets the order be one.
std::vector<Term> at_whole_orders(const Evidence&, const Term& free_order);

}  // namespace qerr
