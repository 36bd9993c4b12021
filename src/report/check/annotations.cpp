#include <algorithm>

#include "report/check/parts.hpp"

/// Workflow commands of GitHub Actions.
namespace qerr {

namespace {

/// Text of a message, or of a property, which may contain no separators either.
std::string escaped_command(const std::string& text, bool property) {
  std::string out;
  for (const char c : text) {
    if (c == '%')
      out += "%25";
    else if (c == '\r')
      out += "%0D";
    else if (c == '\n')
      out += "%0A";
    else if (property && c == ':')
      out += "%3A";
    else if (property && c == ',')
      out += "%2C";
    else
      out += c;
  }
  return out;
}

std::string command(const Place& place, const std::string& message) {
  std::string properties;
  if (!place.file.empty() && place.file != "-" && !place.file.starts_with("--set ")) {
    properties = " file=" + escaped_command(place.file, true);
    if (place.line > 0) properties += ",line=" + std::to_string(place.line);
  }
  return "::error" + properties + "::" + escaped_command(message, false) + "\n";
}

/// At the requirement on the quantity, or else at the spec.
Place place_of_quantity(const Spec& spec, const std::string& quantity) {
  for (const Requirement& r : spec.requirements)
    if (r.quantity == quantity) return r.place;
  return {spec.file, 0, 0};
}

std::string regression_commands(const SpecCheck& check) {
  const Spec& spec = check.analysis.spec;
  const std::vector<FigureChange> worst = check.baseline->worst_by_quantity();
  std::string out;
  for (std::size_t i = 0; i < std::min(worst.size(), most_regressions); ++i)
    out += command(place_of_quantity(spec, worst[i].figure.quantity),
                   verdict(worst[i]) + ", worse than in " + check.baseline->file);
  if (worst.size() > most_regressions) out += command({spec.file, 0, 0}, verdict(*check.baseline));
  return out;
}

}  // namespace

std::string github_annotations(const CheckReport& report) {
  std::string out;
  for (const SpecCheck& check : report.specs)
    for (std::size_t i = 0; i < check.results.size(); ++i) {
      const Requirement& r = check.analysis.spec.requirements[i];
      if (!check.results[i].met) out += command(r.place, verdict(r, check.results[i]));
    }
  for (const BrokenSpec& b : report.broken) out += github_annotations(b.error);
  for (const SpecCheck& check : report.specs)
    if (check.baseline) out += regression_commands(check);
  return out;
}

std::string github_annotations(const Error& error) {
  std::string out;
  for (Fault fault : error.faults()) {
    const Place place = fault.place;
    fault.place = {};
    out += command(place, Error(fault).what());
  }
  return out;
}

}  // namespace qerr
