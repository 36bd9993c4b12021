#include <map>

#include "core/text.hpp"
#include "qerr/report/analysis.hpp"
#include "report/check/parts.hpp"

namespace qerr {

namespace {

/// XML 1.0 has no way to write most control characters, and a viewer shows the others as they are.
std::string xml(const std::string& raw) {
  const std::size_t line = raw.find('\n');
  if (line != std::string::npos) return xml(raw.substr(0, line)) + "&#10;" + xml(raw.substr(line + 1));
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

/// A test case; @param inside  its elements, "" without
std::string test_case(const std::string& spec, const std::string& name, const std::string& inside) {
  const std::string begin =
      "    <testcase classname=\"" + xml(spec) + "\" name=\"" + xml(name) + "\" time=\"0\"";
  return begin + (inside.empty() ? "/>\n" : ">\n      " + inside + "\n    </testcase>\n");
}

std::string element(const std::string& tag, const std::string& type, const std::string& message,
                    const std::string& text) {
  return '<' + tag + " type=\"" + type + "\" message=\"" + xml(message) + "\">" + xml(text) + "</" + tag +
         '>';
}

std::string baseline_case(const std::string& spec, const BaselineCheck& b) {
  std::string all;
  for (const FigureChange& c : b.regressions) all += verdict(c) + '\n';
  return test_case(spec, "baseline " + b.file,
                   b.regressions.empty() ? "" : element("failure", "regression", verdict(b), all));
}

struct SuiteCounts {
  std::size_t tests = 0, failures = 0, errors = 0;
};

std::string suite(const std::string& spec, std::size_t id, const std::string& time, const SuiteCounts& counts,
                  double seconds, const std::string& cases) {
  return "  <testsuite name=\"" + xml(spec) + "\" package=\"qerr\" id=\"" + std::to_string(id) +
         "\" timestamp=\"" + time + "\" hostname=\"localhost\" tests=\"" + std::to_string(counts.tests) +
         "\" failures=\"" + std::to_string(counts.failures) + "\" errors=\"" + std::to_string(counts.errors) +
         "\" time=\"" + fixed_point(seconds, 3) + "\">\n    <properties/>\n" + cases +
         "    <system-out/>\n    <system-err/>\n  </testsuite>\n";
}

/// @param used  how often each name of a case stands in the suites before
std::string suite_of(const SpecCheck& check, std::size_t id, const std::string& time,
                     std::map<std::string, int>& used) {
  const Spec& spec = check.analysis.spec;
  SuiteCounts counts{check.results.size()};
  std::string cases;
  for (std::size_t i = 0; i < check.results.size(); ++i) {
    const Requirement& r = spec.requirements[i];
    const int copy = ++used[spec.file + '\n' + limited(r)];
    const std::string message = verdict(r, check.results[i]);
    const std::string place = r.place.file + ':' + std::to_string(r.place.line) + ": ";
    counts.failures += !check.results[i].met;
    cases += test_case(spec.file, limited(r) + (copy > 1 ? " (" + std::to_string(copy) + ")" : ""),
                       check.results[i].met ? "<system-out>" + xml(message) + "</system-out>"
                                            : element("failure", "requirement", message, place + message));
  }
  if (check.baseline) {
    cases += baseline_case(spec.file, *check.baseline);
    counts.failures += !check.baseline->regressions.empty();
    ++counts.tests;
  }
  return suite(spec.file, id, time, counts, check.seconds, cases);
}

}  // namespace

std::string junit(const CheckReport& report, const std::string& time) {
  std::map<std::string, int> used;
  std::string out = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n";
  for (std::size_t i = 0; i < report.specs.size(); ++i) out += suite_of(report.specs[i], i, time, used);
  for (std::size_t i = 0; i < report.broken.size(); ++i) {
    const BrokenSpec& b = report.broken[i];
    out += suite(b.file, report.specs.size() + i, time, {1, 0, 1}, 0,
                 test_case(b.file, "spec", element("error", "input", b.error.what(), b.error.what())));
  }
  return out + "</testsuites>\n";
}

}  // namespace qerr
