#include <cmath>

#include "report/csv_text.hpp"
#include "report/diagnosis/parts.hpp"
#include "report/formats.hpp"

namespace qerr {

namespace {

/// What a row is about.
struct Subject {
  std::string section, joint = {}, name = {};
};

/// A cell without a value is empty.
struct Figure {
  std::string figure = {};
  double value = NAN, lower = NAN, upper = NAN, p_value = NAN;
  std::string unit = {}, text = {};
};

std::string line(const Subject& s, const Figure& f) {
  std::string text = s.section + ',' + csv_cell(s.joint) + ',' + csv_cell(s.name) + ',' + csv_cell(f.figure);
  for (const double value : {f.value, f.lower, f.upper, f.p_value}) text += ',' + csv_number(value);
  return text + ',' + f.unit + ',' + csv_cell(f.text) + "\r\n";
}

/// The figures that are known; the ratio has an interval only if it was computed on held-out blocks.
std::string gain_lines(const Subject& subject, const Gain& g) {
  std::string lines;
  const Json gain = json_of(g);
  const Figure ratio{.figure = "ratio",
                     .value = g.ratio(),
                     .lower = g.held_out ? g.lower : NAN,
                     .upper = g.held_out ? g.upper : NAN,
                     .text = g.held_out ? "held out" : ""};
  for (const auto& [name, value] : gain.members())
    if (name == "ratio")
      lines += line(subject, ratio);
    else if (value.number() && name != "lower" && name != "upper")
      lines += line(
          subject, {.figure = name, .value = *value.number(), .unit = name.starts_with("rms") ? g.unit : ""});
  return lines;
}

std::string cause_lines(const Spec& spec, const Cause& c) {
  const Subject subject{"cause", c.effect.joint, c.effect.type};
  std::string lines;
  for (const ReportedParameter& p : reported_parameters(spec, c))
    lines +=
        line(subject, {p.figure.name, p.figure.value, p.figure.lower, p.figure.upper, c.p_value, p.unit});
  for (const auto& [choice, word] : c.effect.choices)
    lines += line(subject, {.figure = choice, .text = word});
  lines += gain_lines(subject, c.gain);
  if (std::isfinite(c.rms_without))
    lines += line(subject, {.figure = "rms_without", .value = c.rms_without, .unit = c.gain.unit});
  return lines;
}

std::string unexplained_lines(const Spec& spec, const Unidentified& u) {
  const Subject subject{"unexplained", u.joint, u.what};
  const std::string shape(name(u.shape));
  std::string lines;
  if (u.order) lines += line(subject, {"order", *u.order});
  if (u.frequency) lines += line(subject, {.figure = "frequency", .value = *u.frequency, .unit = "Hz"});
  lines +=
      line(subject, {.figure = "amplitude", .value = u.amplitude, .unit = coordinate_unit(spec, u.joint)});
  lines += line(subject, {.figure = "shape", .text = shape});
  for (const auto& [key, value] : u.figures)
    lines += line(subject, {.figure = shape + '.' + key, .value = value, .unit = figure_unit(spec, u, key)});
  return lines;
}

/// What was found stands under `name`, where it begins under `figure` and `value`, the remedy under `text`;
/// in a row of its own the kind.
std::string data_lines(const DataFinding& f) {
  const Subject subject{"data", f.joint, f.what};
  const Figure begin = f.row ? Figure{.figure = "row", .value = static_cast<double>(*f.row), .text = f.remedy}
                       : f.time ? Figure{.figure = "time", .value = *f.time, .unit = "s", .text = f.remedy}
                                : Figure{.text = f.remedy};
  return line(subject, begin) + line(subject, {.figure = "kind", .text = std::string(name(f.kind))});
}

}  // namespace

std::string to_csv(const DiagnosisReport& r, const Style&) {
  const Diagnosis& d = r.diagnosis;
  std::string out = "section,joint,name,figure,value,lower,upper,p_value,unit,text\r\n";
  out += line({.section = "verdict", .name = std::string(name(d.verdict))}, {.text = d.reason});
  for (const std::string& place : d.unjudged) out += line({"verdict", place, "unjudged"}, {});
  for (const DataFinding& f : d.data) out += data_lines(f);
  for (const Comparison& c : d.simulation) {
    const Subject subject{"simulation", c.joint, c.statistic};
    out += line(subject, {.figure = "observed", .value = c.observed, .p_value = c.p_value});
    out += line(subject, {"expected", c.expected});
  }
  for (const Cause& c : d.causes) out += cause_lines(r.spec, c);
  for (const AlternativeCause& a : d.alternatives)
    out +=
        line({"alternative", a.joint, a.effect}, {.figure = "instead of " + a.instead_of, .text = a.record});
  for (const Unidentified& u : d.unexplained) out += unexplained_lines(r.spec, u);
  for (const Visible& v : d.visible)
    out +=
        line({"visible", v.joint, v.effect},
             {.figure = "smallest " + v.parameter, .value = v.smallest, .unit = v.unit, .text = v.hidden_by});
  return out + gain_lines({"gain"}, d.gain);
}

}  // namespace qerr
