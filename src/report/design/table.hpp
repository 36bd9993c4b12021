#pragma once

#include <optional>
#include <string>

#include "qerr/report/design_report.hpp"

namespace qerr {

/// What the table and the page of a design say alike.

/// `120 EUR`, with cents if there are any; `-` if it is not stated.
std::string priced(std::optional<double> price, const std::string& unit);

std::string bits_text(double bits);

/// What a design costs: its price, or the sum of its bits.
std::string cost_of(const DesignReport&, std::optional<double> price, double bits);

/// Family, order, cut-off, noise, delay and tracking error.
std::string filter_sentence(const DesignedFilter&);

/// `kp 400 N m/rad of a1 and a2`; empty without gains.
std::vector<std::string> gain_sentences(const DesignReport&, const Design&);

/// How far the filter is from the quietest one of its tracking error; "" where that is not known.
std::string best_linear_sentence(const DesignedFilter&);

/// @pre there is an optimum
std::string optimum_sentence(const DesignReport&);

/// What the runner-up changes.
/// @pre there is one
std::string runner_up_sentence(const DesignReport&);

}  // namespace qerr
