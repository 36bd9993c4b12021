#include "core/text.hpp"
#include "qerr/report/analysis.hpp"

namespace qerr {

namespace {

std::string xml(const std::string& text) {
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
        // XML 1.0 has no way to write most control characters.
        out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return out;
}

}  // namespace

std::string junit(const CheckReport& report) {
  const Spec& spec = report.analysis.spec;
  std::size_t failed = 0;
  std::string cases;
  for (std::size_t i = 0; i < report.results.size(); ++i) {
    const Requirement& r = spec.requirements[i];
    cases += "  <testcase classname=\"qerr\" name=\"" + xml(r.quantity + ' ' + r.statistic) + "\" file=\"" +
             xml(r.place.file) + "\" line=\"" + std::to_string(r.place.line) + "\"";
    if (report.results[i].met) {
      cases += "/>\n";
      continue;
    }
    ++failed;
    cases += ">\n    <failure message=\"" +
             xml(r.quantity + ' ' + r.statistic + " is " + readable(report.results[i].value, r.unit) +
                 ", at most " + readable(r.at_most, r.unit) + " is required") +
             "\"/>\n  </testcase>\n";
  }
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"" + xml(spec.file) + "\" tests=\"" +
         std::to_string(report.results.size()) + "\" failures=\"" + std::to_string(failed) + "\">\n" + cases +
         "</testsuite>\n";
}

}  // namespace qerr
