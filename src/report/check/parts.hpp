#pragma once

#include <string>

#include "qerr/report/analysis.hpp"
#include "qerr/report/write.hpp"
#include "report/analysis/requirements.hpp"

namespace qerr {

/// The verdicts as a table in Markdown, for the summary of a job.
std::string to_markdown(const CheckReport&, const Style&);

/// `3 of 120 figures worse than in old.json by more than 2 %`, or `none of ...`.
std::string verdict(const BaselineCheck&);

/// `velocity.x.sigma max was 1.00 mm/s and is 1.20 mm/s (+20 %)`.
std::string verdict(const FigureChange& regression);

/// Quantities that a person is told of; the others are counted.
inline constexpr std::size_t most_regressions = 10;

}  // namespace qerr
