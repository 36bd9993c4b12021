#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "input/read_sections.hpp"

namespace qerr {

/// A file with one column per independent joint, in SI units: whatever a log can be (`LogReader`), a bag,
/// too. Its columns are called `JOINT [unit]` or like a signal of a log, or the spec's section `log` names
/// them.
struct JointTable {
  std::string path;
  std::vector<double> time;                           ///< `time [s]`; empty without TimeColumn::required
  Eigen::MatrixXd positions;                          ///< independent joints x rows [rad or m]
  std::vector<RecordedSignal> efforts, temperatures;  ///< of every independent joint, with a time alone
  std::vector<int> lines;                             ///< line of each row, from 1
};

/// Whether a table must have a `time` column that increases.
enum class TimeColumn { none, required };

/// Columns that are not joints of the chain are ignored with a warning.
/// @throws Error (input) with the place of a missing or duplicate column, a wrong unit, or time that does not
/// increase
JointTable read_joint_table(const std::string& path, const Spec&, TimeColumn,
                            std::vector<std::string>& warnings);

std::string text_of(const Limits&, const IndependentJoint&);

/// Whether the value is within the limits up to a relative 1e-9, which covers limits printed with rounded
/// decimals.
bool inside(double value, const Limits&);

}  // namespace qerr
