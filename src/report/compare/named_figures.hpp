#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/core/error.hpp"
#include "report/json_value.hpp"

namespace qerr {

/// A value in a JSON report, with its path for messages. Borrows the report and the name of its file.
class ReportMember {
 public:
  ReportMember(const Json& value, const std::string& file) : value_(&value), file_(&file) {}
  ReportMember(Json&&, const std::string&) = delete;

  /// @throws Error (input) if the member is missing, or this is no object
  ReportMember at(std::string_view name) const;
  /// Empty if the member is missing.
  std::optional<ReportMember> find(std::string_view name) const;
  /// @throws Error (input) if this is no array
  std::vector<ReportMember> items() const;
  /// Name and value of each member. @throws Error (input) if this is no object
  std::vector<std::pair<std::string, ReportMember>> members() const;

  bool is_null() const { return value_->is_null(); }
  const std::string& text() const;
  bool boolean() const;
  double number() const;
  double number_or(double of_null) const;  ///< the value that null stands for

  Error fault(const std::string& rule, const std::string& found, const std::string& remedy) const;
  const Json& json() const { return *value_; }

 private:
  ReportMember inner(const Json& value, const std::string& step) const;
  Error unlike(const std::string& wanted) const;

  const Json* value_;
  const std::string* file_;
  std::string path_;
};

}  // namespace qerr
