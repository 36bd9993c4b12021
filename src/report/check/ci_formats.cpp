#include <algorithm>
#include <map>

#include "core/text.hpp"
#include "qerr/report/analysis.hpp"
#include "report/analysis/figures.hpp"
#include "report/compare/parts.hpp"
#include "report/formats.hpp"

namespace qerr {

/// Workflow commands of GitHub Actions.

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

namespace {

/// XML 1.0 has no way to write most control characters, and a viewer shows the others as they are.
std::string xml(const std::string& raw) {
  const std::size_t line = raw.find('\n');
  if (line != std::string::npos) return xml(raw.substr(0, line)) + "&#10;" + xml(raw.substr(line + 1));
  return page::escaped_markup(escaped(raw, std::string::npos));
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

/// The table in Markdown (GitHub's dialect) that a job shows as its summary.

namespace {

/// A name in a cell: as code, in which only the bar and the backtick have a meaning.
std::string code(const std::string& name) {
  std::string text = "`";
  for (const char c : escaped(name, 200)) text += c == '|' ? "\\|" : std::string(1, c == '`' ? '\'' : c);
  return text + '`';
}

std::string row(std::initializer_list<std::string> cells) {
  std::string line = "|";
  for (const std::string& cell : cells) line += ' ' + cell + " |";
  return line + '\n';
}

std::string rows_of(const SpecCheck& check) {
  std::string out;
  for (std::size_t i = 0; i < check.results.size(); ++i) {
    const Requirement& r = check.analysis.spec.requirements[i];
    const RequirementResult& result = check.results[i];
    out += row({code(check.analysis.spec.file), code(limited(r)), value_text(r, result.value),
                result.met         ? "met"
                : result.undecided ? "**not proven**"
                                   : "**not met**"});
  }
  if (check.baseline)
    out += row({code(check.analysis.spec.file), "baseline " + code(check.baseline->file), "",
                check.baseline->regressions.empty() ? "met" : "**" + verdict(*check.baseline) + "**"});
  return out;
}

}  // namespace

std::string to_markdown(const CheckReport& report, const Style&) {
  std::string out = row({"spec", "requirement", "value", "verdict"}) + row({"---", "---", "---", "---"});
  for (const SpecCheck& check : report.specs) out += rows_of(check);
  for (const BrokenSpec& b : report.broken) out += row({code(b.file), "", "", "**cannot be checked**"});
  return out;
}

}  // namespace qerr
