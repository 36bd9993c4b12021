#include <algorithm>
#include <cmath>

#include "core/lists.hpp"
#include "core/text.hpp"
#include "filter/norms/numerical_error.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/report/filter_report.hpp"
#include "report/analysis/tables.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

/// A filter with an identifier of its own, and what its comment says.
struct CodedFilter {
  const FilterFigures& figures;
  std::string name;  ///< `velocity`: letters, digits and underscores
  FilterPlan<DoubleDouble> plan;
  RecursionError of_double, of_float;
  std::vector<std::string> comment;
};

/// Keywords of Python, and names that the code itself uses.
constexpr std::string_view names_in_use[]{
    "False",  "None",     "True",   "and",  "as",    "assert", "async",    "await",   "break", "class",
    "def",    "continue", "del",    "elif", "else",  "if",     "except",   "finally", "for",   "from",
    "global", "in",       "import", "is",   "not",   "lambda", "nonlocal", "or",      "pass",  "raise",
    "try",    "return",   "while",  "with", "yield", "Filter", "float",    "len",     "sum",   "zip"};

std::string in_capitals(std::string text) {
  for (char& c : text)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return text;
}

/// Unlike all others, also in capitals, as C's macros have it.
std::string identifier(const std::string& name, const std::vector<CodedFilter>& others) {
  std::string id;
  for (const char c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    id += plain ? c : '_';
  }
  if (id.empty() || (id[0] >= '0' && id[0] <= '9') || id.starts_with("qerr_") ||
      std::find(std::begin(names_in_use), std::end(names_in_use), id) != std::end(names_in_use))
    id = "filter_" + id;
  const auto taken = [&](const std::string& text) {
    return std::ranges::any_of(
        others, [&](const CodedFilter& f) { return in_capitals(f.name) == in_capitals(text); });
  };
  std::string own = id;
  for (int i = 2; taken(own); ++i) own = id + '_' + std::to_string(i);
  return own;
}

std::string unit_of(const Filter& f) {
  if (f.unit) return "of the control law";
  return f.derivative == 0 ? "1" : rate_unit(f.derivative);
}

std::vector<std::string> comment_of(const CodedFilter& f) {
  const FilterFigures& g = f.figures;
  const double bits = std::ceil(std::log2(f.of_float.largest_signal));
  std::vector<std::string> lines{
      f.name + ": derivative " + std::to_string(g.filter.derivative) + " at " +
          shortest(g.filter.sample_rate) + " Hz, unit " + unit_of(g.filter),
      "H2 norm " + significant(g.norms.h2, 6) + " (sigma out of sigma in), l1 norm " +
          significant(g.norms.l1.upper, 6) + " (peak out of peak in), H(1) = " +
          significant(g.norms.dc_gain, 6) + ", delay " + significant(g.group_delay, 6) + " s",
      "No input, state or output is larger than " + significant(f.of_float.largest_signal, 4) +
          " times the largest input: a fixed point needs " + significant(std::max(bits, 0.0), 6) +
          " bits more than the input before it.",
      "Rounding, largest error of the output over the largest input, underflow aside: " +
          significant(f.of_double.output, 3) + " in double, " + significant(f.of_float.output, 3) +
          " in float"};
  for (const auto& s :
       g.filter.taps.empty() ? second_order_sections(g.filter) : std::vector<std::array<double, 6>>{}) {
    std::string line = "in powers of z^-1: b";
    for (std::size_t i = 0; i < s.size(); ++i) line += (i == 3 ? " / a " : " ") + shortest(s[i]);
    lines.push_back(line);
  }
  return lines;
}

std::vector<CodedFilter> coded(const FilterReport& report) {
  std::vector<CodedFilter> all;
  for (const FilterFigures& f : report.filters) {
    CodedFilter c{f, identifier(f.name, all), levelled_plan(f.filter), {}, {}, {}};
    c.of_double = recursion_error(c.plan, f.filter.sample_rate, std::ldexp(1.0, -53));
    c.of_float = recursion_error(c.plan, f.filter.sample_rate, std::ldexp(1.0, -24));
    c.comment = comment_of(c);
    all.push_back(std::move(c));
  }
  return all;
}

/// Upward to three digits, as the text of a bound.
std::string bound_text(double bound) { return std::isfinite(bound) ? significant(bound * 1.005, 3) : "inf"; }

std::string number(const DoubleDouble& c) { return shortest(static_cast<double>(c)); }

/// The rows `{1, k0, k1, b0, b1, b2}` of a plan's sections, and its taps.
std::string table_of(const CodedFilter& f, const std::string& open, const std::string& close) {
  std::string out;
  for (const NormalizedSection<DoubleDouble>& s : f.plan.sections)
    out += "    " + open + (s.second ? "1" : "0") + ", " + number(s.k0) + ", " + number(s.k1) + ", " +
           number(s.b0) + ", " + number(s.b1) + ", " + number(s.b2) + close + ",\n";
  for (const DoubleDouble& tap : f.plan.taps) out += "    " + number(tap) + ",\n";
  return out;
}

/// What both languages say of the form.
const char* const form =
    "A section (b0 + b1 w + b2 w^2)/(a0 + a1 w + a2 w^2), w = (1 - z^-1)/(1 + z^-1), is run as two "
    "trapezoidal integrators with k0 = a0 and k1 = a0 + a1, which keep their digits at low cut-offs.";

std::string source_of(const FilterReport& report) {
  return "Written by qerr " + std::string(version()) + " from " + escaped(report.spec.file, 80) + ".";
}

constexpr const char* c_sections = R"(
#ifndef QERR_FILTER_SECTIONS
#define QERR_FILTER_SECTIONS
#ifndef QERR_REAL
#define QERR_REAL double /* or float */
#endif
typedef QERR_REAL qerr_real;
typedef struct { int second; qerr_real k0, k1, b0, b1, b2; } qerr_section;

static inline qerr_real qerr_section_step(const qerr_section *c, qerr_real *s, qerr_real x) {
  if (c->second) {
    const qerr_real high = (x - c->k0 * s[1]) - c->k1 * s[0], band = high + s[0], low = s[1] + band;
    s[0] = 2 * high + s[0];
    s[1] = low + band;
    return c->b0 * low + (c->b1 * band + c->b2 * high);
  } else {
    const qerr_real high = x - c->k0 * s[0], low = s[0] + high;
    s[0] = 2 * high + s[0];
    return c->b0 * low + c->b1 * high;
  }
}
#endif
)";

std::string c_of_sections(const CodedFilter& f) {
  const std::string& n = f.name;
  const std::string count = std::to_string(f.plan.sections.size());
  return "static const qerr_section " + n + "_sections[" + count + "] = {\n" + table_of(f, "{", "}") +
         "};\ntypedef struct { qerr_real s[" + count + "][2]; } " + n +
         "_filter; /* all 0: at rest at 0 */\n\n/* As if the input had been x for ever. */\nstatic inline "
         "void " +
         n + "_start(" + n + "_filter *f, qerr_real x) {\n  int i;\n  for (i = 0; i < " + count +
         "; ++i) {\n    const qerr_section *c = &" + n +
         "_sections[i];\n    f->s[i][0] = c->second ? 0 : x / c->k0;\n    f->s[i][1] = c->second ? x / c->k0 "
         ": 0;\n    x = c->b0 * (x / c->k0);\n  }\n}\n\nstatic inline qerr_real " +
         n + "_step(" + n + "_filter *f, qerr_real x) {\n  int i;\n  for (i = 0; i < " + count +
         "; ++i) x = qerr_section_step(&" + n + "_sections[i], f->s[i], x);\n  return x;\n}\n";
}

std::string c_of_taps(const CodedFilter& f) {
  const std::string& n = f.name;
  const std::string count = std::to_string(f.plan.taps.size());
  return "static const qerr_real " + n + "_taps[" + count + "] = {\n" + table_of(f, "", "") +
         "};\ntypedef struct { qerr_real past[" + count + "]; int newest; } " + n +
         "_filter; /* all 0: at rest at 0 */\n\n/* As if the input had been x for ever. */\nstatic inline "
         "void " +
         n + "_start(" + n + "_filter *f, qerr_real x) {\n  for (f->newest = 0; f->newest < " + count +
         " - 1; ++f->newest) f->past[f->newest] = x;\n  f->past[f->newest] = x;\n}\n\nstatic inline "
         "qerr_real " +
         n + "_step(" + n +
         "_filter *f, qerr_real x) {\n  qerr_real y = 0;\n  int i, at;\n  f->newest = (f->newest == 0 ? " +
         count + " : f->newest) - 1;\n  f->past[at = f->newest] = x;\n  for (i = 0; i < " + count +
         "; ++i) {\n    y += " + n + "_taps[i] * f->past[at];\n    at = at + 1 == " + count +
         " ? 0 : at + 1;\n  }\n  return y;\n}\n";
}

std::string c_code(const FilterReport& report) {
  std::string out = "/* " + source_of(report) + "\n" + wrapped(form, 110, " * ") +
                    " * #define QERR_REAL float before the #include for single precision. */\n" + c_sections;
  for (const CodedFilter& f : coded(report)) {
    out += "\n/*\n";
    for (const std::string& line : f.comment) out += wrapped(line, 110, " * ");
    const std::string upper = in_capitals(f.name);
    const auto define = [&](const char* what, double bound) {
      out += "#define " + upper + what + ' ' + (std::isfinite(bound) ? bound_text(bound) : "HUGE_VAL") +
             " /* [" + unit_of(f.figures.filter) + "] times the largest |input| */\n";
    };
    out += " */\n";
    define("_DOUBLE_ERROR", f.of_double.output);
    define("_FLOAT_ERROR", f.of_float.output);
    out += f.plan.sections.empty() ? c_of_taps(f) : c_of_sections(f);
  }
  return out;
}

constexpr const char* python_filter = R"(

class Filter:
    """A filter, sample by sample."""

    SECTIONS = ()  # (second order, k0, k1, b0, b1, b2)
    TAPS = ()

    def __init__(self, x=0.0):
        """Starts as if the input had been x for ever."""
        self.states = []
        for second, k0, _, b0, _, _ in self.SECTIONS:
            self.states.append([0.0, x / k0] if second else [x / k0, 0.0])
            x = b0 * (x / k0)
        self.past = [x] * len(self.TAPS)

    def step(self, x):
        for (second, k0, k1, b0, b1, b2), s in zip(self.SECTIONS, self.states):
            if second:
                high = (x - k0 * s[1]) - k1 * s[0]
                band = high + s[0]
                low = s[1] + band
                s[0] += 2 * high
                s[1] = low + band
                x = b0 * low + (b1 * band + b2 * high)
            else:
                high = x - k0 * s[0]
                low = s[0] + high
                s[0] += 2 * high
                x = b0 * low + b1 * high
        if not self.TAPS:
            return x
        self.past = [x] + self.past[:-1]
        return sum(c * p for c, p in zip(self.TAPS, self.past))
)";

std::string python_code(const FilterReport& report) {
  std::string out = "\"\"\"" + source_of(report) + "\n\n" + wrapped(form, 110) + "\"\"\"\n" + python_filter;
  for (const CodedFilter& f : coded(report)) {
    out += "\n\nclass " + f.name + "(Filter):\n    \"\"\"\n";
    for (const std::string& line : f.comment) out += wrapped(line, 110, "    ");
    out += "    \"\"\"\n\n    DOUBLE_ERROR = " +
           (std::isfinite(f.of_double.output) ? bound_text(f.of_double.output) : "float(\"inf\")") +
           "  # times the largest |input|\n    " + (f.plan.sections.empty() ? "TAPS" : "SECTIONS") +
           " = (\n" + table_of(f, "    (", ")") + "    )\n";
  }
  return out;
}

/// A chain of one filter a section; the coefficients as doubles must still be those of a stable filter.
std::string ros_code(const FilterReport& report) {
  std::string out = "# " + source_of(report) + "\n";
  for (const CodedFilter& f : coded(report)) {
    const Filter& filter = f.figures.filter;
    for (const std::string& line : f.comment)
      if (!line.starts_with("Rounding") && !line.starts_with("in powers")) out += wrapped(line, 110, "# ");
    out += f.name + ":\n";
    std::size_t entry = 0;
    const auto add = [&](const std::string& a, const std::string& b) {
      out += "  - {name: " + f.name + '_' + std::to_string(++entry) +
             ", type: filters/MultiChannelTransferFunctionFilterDouble, params: {a: [" + a + "], b: [" + b +
             "]}}\n";
    };
    if (f.plan.sections.empty()) {
      add("1", joined(f.plan.taps, ", ", [](const DoubleDouble& tap) { return number(tap); }));
      continue;
    }
    Rows rows;
    for (const auto& s : second_order_sections(filter)) rows.emplace_back(s.begin(), s.end());
    try {
      filter_from_sections(rows, filter.sample_rate, filter.derivative);
    } catch (const Error&) {
      throw Error({report.spec.file, 0, 0}, "filters." + f.figures.name,
                  "the filter is too slow for coefficients in powers of z^-1, as doubles",
                  "largest pole modulus 1 - " + significant(1 - f.figures.poles_max_modulus, 3),
                  "write it as c or python");
    }
    for (const auto& s : rows)
      add(shortest(s[3]) + ", " + shortest(s[4]) + ", " + shortest(s[5]),
          shortest(s[0]) + ", " + shortest(s[1]) + ", " + shortest(s[2]));
  }
  return out;
}

}  // namespace

const std::vector<CodeLanguage>& code_languages() {
  static const std::vector<CodeLanguage> all{
      {"c", ".h .c", "C99, in double or float; the errors of both are bounded", c_code},
      {"python", ".py", "Python without libraries", python_code},
      {"ros", ".yaml", "chains of ROS transfer function filters", ros_code}};
  return all;
}

}  // namespace qerr
