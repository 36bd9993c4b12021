#pragma once

#include <string>

#include "qerr/report/filter_report.hpp"

/// Pictures of the page of `filter` that compare a filter with its neighbours, as markup.
namespace qerr {

/// `1/s` of a velocity, "" of a position.
std::string rate_unit(int derivative);

/// ||H||_2 and ||H||_1 of the same family at cut-offs from a tenth to ten times the stated one, and the
/// stated one marked; a sentence for a filter that has no cut-off.
std::string cutoff_figure(const FilterFigures&);

/// Noise against delay, one picture for each derivative and sample rate: the report's filters, and the
/// undominated low-passes of all families that have a cut-off.
std::string noise_figures(const FilterReport&);

}  // namespace qerr
