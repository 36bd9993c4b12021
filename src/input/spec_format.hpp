#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/core/parameter.hpp"

namespace qerr {

/// The rows of every section of the spec that is not a family. The strict reader and the JSON Schema use the
/// same rows, so that keys, kinds, ranges and defaults agree.
namespace spec_format {

extern const std::vector<Parameter> top;
extern const std::vector<Parameter> robot;
extern const std::vector<Parameter> pose;
extern const std::vector<Parameter> joint;
extern const std::vector<Parameter> dh_row;
const std::vector<Parameter>& filter();
extern const std::vector<Parameter> lowpass;  ///< without the family's own parameters
extern const std::vector<Parameter> configurations;
const std::vector<Parameter>& requirement();
extern const std::vector<Parameter> threshold;
extern const std::vector<Parameter> motion;
extern const std::vector<Parameter> joint_motion;
extern const std::vector<Parameter> sine;
extern const std::vector<Parameter> move;
extern const std::vector<Parameter> effect;  ///< without the effect's own parameters
extern const std::vector<Parameter> control;
extern const std::vector<Parameter> controller;  ///< of a joint
extern const std::vector<Parameter> tip_impedance;
extern const std::vector<Parameter> estimator;
extern const std::vector<Parameter> wall;
extern const std::vector<Parameter> log;
extern const std::vector<Parameter> log_column;
extern const std::vector<Parameter> sweep;
extern const std::vector<Parameter> design;
extern const std::vector<Parameter> design_filter;
extern const std::vector<Parameter> design_gains;
extern const std::vector<Parameter> design_tracking;

/// The keys whose values are paths of files, relative to the spec. `*` is any key, `[]` any item of a list.
const std::vector<std::string_view>& file_keys();
/// Whether a key is one of them, or a section that has one.
bool may_name_a_file(std::string_view key);

/// The dimension of the number at a dotted path in `filters`, `threshold` or `motion`; empty for other keys,
/// of which it depends on the joint or the effect, or that are no numbers.
std::optional<Dimension> dimension_of(const std::string& path);

}  // namespace spec_format

}  // namespace qerr
