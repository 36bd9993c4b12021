#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "qerr/core/parameter.hpp"
#include "qerr/report/write.hpp"

/// What the formats offer to write.cpp, one function per answer.
namespace qerr {

/// A member of a family as `qerr list` shows it.
struct ListRow {
  std::string name;
  std::string summary;
  std::vector<Parameter> parameters = {};
  std::vector<std::pair<std::string, std::string>> notes = {};  ///< name and text, the same names in all rows
};

std::string parameter_unit(const Parameter&);

std::string to_json(const Analysis&);
std::string check_json(const Analysis&);
std::string threshold_json(const std::vector<ThresholdRow>&);
std::string rows_json(const std::vector<ListRow>&);

std::string to_csv(const Analysis&);
std::string check_csv(const Analysis&);
std::string threshold_csv(const std::vector<ThresholdRow>&);
std::string rows_csv(const std::vector<ListRow>&);

std::string to_table(const Analysis&, const Style&);
std::string check_table(const Analysis&, const Style&);
std::string threshold_table(const std::vector<ThresholdRow>&, const Style&);
std::string rows_table(const std::vector<ListRow>&);

}  // namespace qerr
