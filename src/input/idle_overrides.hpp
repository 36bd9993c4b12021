#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/input/spec.hpp"

namespace qerr {

/// What a report says of a spec, as text.
using ReportText = std::function<std::string(const Spec&)>;

/// Warnings of overrides that change nothing of a report: it is compared with that of the spec without them,
/// one by one. An override that repeats the value which holds is not warned of.
/// @param spec     as `parse_spec` returns it with the overrides
/// @param unused   sections of the spec that the command does not use
/// @param reports  the quickest first: the next is asked where this one shows no change. None: only
///                 overrides of unused sections are found
std::vector<std::string> idle_overrides(const Spec& spec, const SpecOverrides&,
                                        const std::vector<std::string_view>& unused,
                                        const std::vector<ReportText>& reports);

/// Refuses overrides of encoders and of low-passes all of which the section `design` chooses.
/// @pre spec.design
/// @throws Error (input)
void refuse_chosen(const Spec& spec, const SpecOverrides&);

/// Refuses, for a sweep, overrides of keys that it varies.
/// @throws Error (input)
void refuse_varied(const Spec& spec, const SpecOverrides&);

}  // namespace qerr
