#include "core/text.hpp"
#include "qerr/report/analysis.hpp"
#include "report/check/parts.hpp"

namespace qerr {

namespace {

/// XML 1.0 has no way to write most control characters, and a viewer shows the others as they are.
std::string xml(const std::string& raw) {
  const std::string text = escaped(raw, std::string::npos);
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string baseline_case(const BaselineCheck& b) {
  const std::string begin =
      "    <testcase classname=\"qerr.check\" name=\"" + xml("baseline " + b.file) + "\" time=\"0\"";
  if (b.regressions.empty()) return begin + "/>\n";
  std::string all;
  for (const FigureChange& c : b.regressions) all += xml(verdict(c)) + '\n';
  return begin + ">\n      <failure type=\"regression\" message=\"" + xml(verdict(b)) + "\">" + all +
         "</failure>\n    </testcase>\n";
}

/// Ant's schema requires all these attributes and elements, and permits no place of a test case.
std::string suite_of(const SpecCheck& check, std::size_t id, const std::string& time) {
  const Spec& spec = check.analysis.spec;
  std::size_t failed = 0;
  std::string cases;
  for (std::size_t i = 0; i < check.results.size(); ++i) {
    const Requirement& r = spec.requirements[i];
    cases += "    <testcase classname=\"qerr.check\" name=\"" + xml(r.name()) + "\" time=\"0\"";
    if (check.results[i].met) {
      cases += "/>\n";
      continue;
    }
    ++failed;
    const std::string message = verdict(r, check.results[i]);
    cases += ">\n      <failure type=\"requirement\" message=\"" + xml(message) + "\">" + xml(r.place.file) +
             ":" + std::to_string(r.place.line) + ": " + xml(message) + "</failure>\n    </testcase>\n";
  }
  std::size_t tests = check.results.size();
  if (check.baseline) {
    cases += baseline_case(*check.baseline);
    failed += !check.baseline->regressions.empty();
    ++tests;
  }
  return "  <testsuite name=\"" + xml(spec.file) + "\" package=\"qerr\" id=\"" + std::to_string(id) +
         "\" timestamp=\"" + time + "\" hostname=\"localhost\" tests=\"" + std::to_string(tests) +
         "\" failures=\"" + std::to_string(failed) + "\" errors=\"0\" time=\"" +
         fixed_point(check.seconds, 3) + "\">\n    <properties/>\n" + cases +
         "    <system-out/>\n    <system-err/>\n  </testsuite>\n";
}

}  // namespace

std::string junit(const CheckReport& report, const std::string& time) {
  std::string out = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n";
  for (std::size_t i = 0; i < report.specs.size(); ++i) out += suite_of(report.specs[i], i, time);
  return out + "</testsuites>\n";
}

}  // namespace qerr
