#include <cmath>

#include "report/csv_text.hpp"
#include "report/diagnosis/parts.hpp"
#include "report/formats.hpp"

namespace qerr {

namespace {

/// Rows of section,joint,name,figure,value,lower,upper,p_value,unit; a cell without a value is empty.
class Tidy {
 public:
  struct Row {
    std::string section = {}, joint = {}, name = {}, figure = {};
    double value = NAN, lower = NAN, upper = NAN, p_value = NAN;
    std::string unit = {}, text = {};
  };

  void add(const Row& r) {
    text_ += r.section + ',' + csv_cell(r.joint) + ',' + csv_cell(r.name) + ',' + csv_cell(r.figure);
    for (const double value : {r.value, r.lower, r.upper, r.p_value}) text_ += ',' + csv_number(value);
    text_ += ',' + r.unit + ',' + csv_cell(r.text) + "\r\n";
  }

  void add_gain(const std::string& section, const std::string& joint, const std::string& name,
                const Gain& g) {
    const auto figure = [&](const char* what, double value, const std::string& unit) {
      if (std::isfinite(value))
        add({.section = section, .joint = joint, .name = name, .figure = what, .value = value, .unit = unit});
    };
    figure("rms_before", g.rms_before, g.unit);
    figure("rms_after", g.rms_after, g.unit);
    // The ratio has an interval only if it was computed on held-out blocks.
    add({.section = section,
         .joint = joint,
         .name = name,
         .figure = "ratio",
         .value = g.ratio(),
         .lower = g.held_out ? g.lower : NAN,
         .upper = g.held_out ? g.upper : NAN,
         .text = g.held_out ? "held out" : ""});
    figure("counts_before", g.counts_before, "");
    figure("counts_after", g.counts_after, "");
    figure("sigma_ratio", g.sigma_ratio, "");
    figure("log_score", g.log_score, "");
    figure("coverage", g.coverage, "");
  }

  std::string text() const {
    return "section,joint,name,figure,value,lower,upper,p_value,unit,text\r\n" + text_;
  }

 private:
  std::string text_;
};

void add_causes(Tidy& rows, const DiagnosisReport& r) {
  for (const Cause& c : r.diagnosis.causes) {
    for (const ReportedParameter& p : reported_parameters(r.spec, c))
      rows.add({"cause", c.effect.joint, c.effect.type, p.figure.name, p.figure.value, p.figure.lower,
                p.figure.upper, c.p_value, p.unit});
    for (const auto& [choice, word] : c.effect.choices)
      rows.add({.section = "cause",
                .joint = c.effect.joint,
                .name = c.effect.type,
                .figure = choice,
                .text = word});
    rows.add_gain("cause", c.effect.joint, c.effect.type, c.gain);
    if (std::isfinite(c.rms_without))
      rows.add({.section = "cause",
                .joint = c.effect.joint,
                .name = c.effect.type,
                .figure = "rms_without",
                .value = c.rms_without,
                .unit = c.gain.unit});
  }
}

void add_unexplained(Tidy& rows, const DiagnosisReport& r) {
  for (const Unidentified& u : r.diagnosis.unexplained) {
    if (u.order)
      rows.add(
          {.section = "unexplained", .joint = u.joint, .name = u.what, .figure = "order", .value = *u.order});
    if (u.frequency)
      rows.add({.section = "unexplained",
                .joint = u.joint,
                .name = u.what,
                .figure = "frequency",
                .value = *u.frequency,
                .unit = "Hz"});
    rows.add({.section = "unexplained",
              .joint = u.joint,
              .name = u.what,
              .figure = "amplitude",
              .value = u.amplitude,
              .unit = coordinate_unit(r.spec, u.joint)});
    rows.add({.section = "unexplained",
              .joint = u.joint,
              .name = u.what,
              .figure = "shape",
              .text = std::string(name(u.shape))});
    for (const auto& [key, value] : u.figures)
      rows.add({.section = "unexplained",
                .joint = u.joint,
                .name = u.what,
                .figure = std::string(name(u.shape)) + '.' + key,
                .value = value,
                .unit = figure_unit(r.spec, u, key)});
  }
}

/// What was found stands under `name`, where it begins under `figure` and `value`, the remedy under `text`;
/// in a row of its own the kind.
void add_data(Tidy& rows, const Diagnosis& d) {
  for (const DataFinding& f : d.data) {
    rows.add({.section = "data",
              .joint = f.joint,
              .name = f.what,
              .figure = f.row    ? "row"
                        : f.time ? "time"
                                 : "",
              .value = f.row ? static_cast<double>(*f.row) : f.time.value_or(NAN),
              .unit = !f.row && f.time ? "s" : "",
              .text = f.remedy});
    rows.add({.section = "data",
              .joint = f.joint,
              .name = f.what,
              .figure = "kind",
              .text = std::string(name(f.kind))});
  }
}

void add_visible(Tidy& rows, const Diagnosis& d) {
  for (const Visible& v : d.visible)
    rows.add({.section = "visible",
              .joint = v.joint,
              .name = v.effect,
              .figure = "smallest " + v.parameter,
              .value = v.smallest,
              .unit = v.unit,
              .text = v.hidden_by});
}

}  // namespace

std::string to_csv(const DiagnosisReport& r, const Style&) {
  const Diagnosis& d = r.diagnosis;
  Tidy rows;
  rows.add({.section = "verdict", .name = std::string(name(d.verdict)), .text = d.reason});
  for (const std::string& place : d.unjudged)
    rows.add({.section = "verdict", .joint = place, .name = "unjudged"});
  add_data(rows, d);
  for (const Comparison& c : d.simulation) {
    rows.add({.section = "simulation",
              .joint = c.joint,
              .name = c.statistic,
              .figure = "observed",
              .value = c.observed,
              .p_value = c.p_value});
    rows.add({.section = "simulation",
              .joint = c.joint,
              .name = c.statistic,
              .figure = "expected",
              .value = c.expected});
  }
  add_causes(rows, r);
  for (const AlternativeCause& a : d.alternatives)
    rows.add({.section = "alternative",
              .joint = a.joint,
              .name = a.effect,
              .figure = "instead of " + a.instead_of,
              .text = a.record});
  add_unexplained(rows, r);
  add_visible(rows, d);
  rows.add_gain("gain", "", "", d.gain);
  return rows.text();
}

}  // namespace qerr
