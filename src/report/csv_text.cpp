#include "report/csv_text.hpp"

#include <cmath>

#include "qerr/core/error.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

std::string csv_cell(const std::string& cell) {
  const std::string text = escaped(cell, std::string::npos);
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

std::string csv_number(double value) { return std::isfinite(value) ? shortest(value) : std::string(); }

std::string csv_number(const std::optional<double>& value) {
  return value ? csv_number(*value) : std::string();
}

}  // namespace qerr
