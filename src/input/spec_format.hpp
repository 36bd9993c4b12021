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

const std::vector<Parameter>& top();
const std::vector<Parameter>& robot();
const std::vector<Parameter>& pose();
const std::vector<Parameter>& joint();
const std::vector<Parameter>& dh_row();
const std::vector<Parameter>& filter();
const std::vector<Parameter>& lowpass();  ///< without the family's own parameters
const std::vector<Parameter>& configurations();
const std::vector<Parameter>& requirement();
const std::vector<Parameter>& threshold();
const std::vector<Parameter>& motion();
const std::vector<Parameter>& joint_motion();
const std::vector<Parameter>& sine();
const std::vector<Parameter>& move();
const std::vector<Parameter>& effect();  ///< without the effect's own parameters
const std::vector<Parameter>& control();
const std::vector<Parameter>& controller();  ///< of a joint
const std::vector<Parameter>& tip_impedance();
const std::vector<Parameter>& estimator();
const std::vector<Parameter>& wall();
const std::vector<Parameter>& log();
const std::vector<Parameter>& log_column();
const std::vector<Parameter>& sweep();
const std::vector<Parameter>& design();
const std::vector<Parameter>& design_filter();
const std::vector<Parameter>& design_gains();
const std::vector<Parameter>& design_tracking();

/// The keys whose values are paths of files, relative to the spec. `*` is any key, `[]` any item of a list.
const std::vector<std::string_view>& file_keys();
/// Whether a key is one of them, or a section that has one.
bool may_name_a_file(std::string_view key);

/// The dimension of the number at a dotted path in `filters`, `threshold` or `motion`; empty for other keys,
/// of which it depends on the joint or the effect, or that are no numbers.
std::optional<Dimension> dimension_of(const std::string& path);

}  // namespace spec_format

}  // namespace qerr
