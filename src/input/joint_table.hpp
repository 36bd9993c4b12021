#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "input/read_sections.hpp"

namespace qerr {

/// A CSV file with one column per independent joint, `JOINT` or `JOINT [unit]`, in SI units.
struct JointTable {
  std::string path;
  std::vector<double> time;   ///< `time [s]`; empty when it was not asked for
  Eigen::MatrixXd positions;  ///< independent joints x rows [rad or m]
  std::vector<int> lines;     ///< line of each row, from 1
};

/// Whether a table must have a `time` column that increases.
enum class TimeColumn { none, required };

/// Columns that are no joint of the chain are ignored with a warning.
/// @throws Error (input) with the line for a missing or repeated column, a wrong unit, time that does not
/// increase
JointTable read_joint_table(const std::string& path, const Chain&, TimeColumn,
                            std::vector<std::string>& warnings);

/// The limits of a joint in its unit, for a message.
std::string text_of(const Limits&, const IndependentJoint&);

/// Rounded decimals of a limit may lie a hair outside it.
bool inside(double value, const Limits&);

}  // namespace qerr
