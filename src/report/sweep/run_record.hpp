#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "report/sweep/grid.hpp"

namespace qerr {

/// What the rows of a sweep depend on: the version of qerr, the spec, the files that it names, the options,
/// and the number of variants, each with its value or a fingerprint (16 digits of SHA-256).
///
/// Rows of one record may stand in one file; `difference` names what keeps two records apart.
class RunRecord {
 public:
  RunRecord() = default;
  /// @param options  names and values of those on which the rows depend
  /// @throws Error (file_system) for a file of a step that cannot be read
  RunRecord(const SpecVariants&, const SweepGrid&,
            const std::vector<std::pair<std::string, std::string>>& options);
  /// Reads `text()` back.
  explicit RunRecord(std::string_view text);

  /// One line without commas and quotation marks: `NAME=VALUE; NAME=VALUE`, sorted.
  std::string text() const;
  /// The names of the entries in which the records differ, for messages; "" if they agree.
  std::string difference(const RunRecord& other) const;
  /// The value of an entry; "" if there is none.
  std::string value(std::string_view name) const;

 private:
  std::vector<std::pair<std::string, std::string>> entries_;  // sorted
};

}  // namespace qerr
