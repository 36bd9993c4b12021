#include "qerr/report/diagnosis_report.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "report/diagnosis/parts.hpp"
#include "report/formats.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

/// Index of the independent joint of this name, and of its encoder; empty if unknown.
std::optional<std::size_t> joint_place(const Spec& spec, const std::string& name) {
  const auto& joints = spec.model.chain.independent;
  const auto found = std::ranges::find(joints, name, &IndependentJoint::name);
  if (found == joints.end()) return std::nullopt;
  return found - joints.begin();
}

Log described(const Log& log) {
  return {log.file,      log.columns,      log.rows,     log.first_time,
          log.last_time, log.time_origin,  log.warnings, {},
          log.stretches, log.stretch_rows, {},           log.misspelt};
}

std::string note(const Spec& spec, const Cause& cause) {
  std::string text = cause.effect.type + " of " + escaped(cause.effect.joint, 60);
  for (const ReportedParameter& p : reported_parameters(spec, cause))
    if (!p.fixed) text += ", " + p.figure.name + ' ' + with_interval(p);
  return text;
}

/// Whether a spec can state the filter: a low-pass without an additional delay.
bool is_filter(const Effect& e) {
  return effect_kind(e.type).is_filter && e.choices.count("family") && e.number_or("order", 0) > 0 &&
         e.number_or("delay", 0) == 0;
}

std::string free_name(const Spec& spec, const std::vector<AddedFilter>& added, const std::string& wanted) {
  const auto taken = [&](const std::string& name) {
    return find_named(spec.filters, name) || find_named(added, name);
  };
  std::string name = wanted;
  for (int i = 2; taken(name); ++i) name = wanted + '_' + std::to_string(i);
  return name;
}

/// The filters that computed the velocities of the log. If none of the velocities is of the spec's only
/// filter, the first one replaces it; the others are added.
std::vector<AddedFilter> found_filters(const DiagnosisReport& r) {
  std::vector<AddedFilter> filters;
  std::vector<std::string> stated;
  for (const NamedFilter& f : r.spec.filters)
    if (f.filter.derivative == 1) stated.push_back(f.name);
  const auto& columns = r.log.columns;
  const auto velocities =
      std::ranges::count_if(columns, [](const LogColumn& c) { return c.signal == LogSignal::velocity; });
  const auto& causes = r.diagnosis.causes;
  const auto others = std::ranges::count_if(causes, [](const Cause& c) { return is_filter(c.effect); });
  for (const Cause& c : causes) {
    if (!is_filter(c.effect) || stated.empty()) continue;
    const bool instead = filters.empty() && stated.size() == 1 && others == velocities;
    const std::string name =
        instead ? stated[0] : free_name(r.spec, filters, stated[0] + '_' + c.effect.joint);
    filters.push_back({name, c.effect.choices.at("family"), static_cast<int>(c.effect.number("order")),
                       c.effect.number("cutoff"), note(r.spec, c)});
  }
  return filters;
}

using ReportedCause = In<Cause, DiagnosisReport>;
using ReportedError = In<Unidentified, DiagnosisReport>;

std::optional<ResidualCurve> curve(const auto& of) { return only_if(!of->curve.at.empty(), of->curve); }

/// The rms of its contribution to the readings, in counts of its joint's encoder.
std::optional<double> counts(const ReportedCause& c) {
  const Encoder* encoder = encoder_of(c.whole.spec, c->effect.joint);
  return encoder && c->rms > 0 ? std::optional(c->rms / encoder->resolution) : std::nullopt;
}

auto figure_units(const ReportedError& u) {
  return by_name(
      u->figures, [](auto& f) { return f.first; },
      [&](auto& f) { return figure_unit(u.whole.spec, *u, f.first); });
}

template <class T>
auto of_diagnosis(T Diagnosis::*value) {
  return [value](const DiagnosisReport& r) { return r.diagnosis.*value; };
}

std::vector<LogColumn> unwrapped(const Log& log) {
  std::vector<LogColumn> columns;
  for (const LogColumn& c : log.columns)
    if (c.wraps.count > 0 || c.wraps.start != 0) columns.push_back(c);
  return columns;
}

/// What a row is about.
struct Subject {
  std::string section, joint = {}, name = {};
};

/// A cell without a value is empty.
struct ReportedFigure {
  std::string figure = {};
  double value = NAN, lower = NAN, upper = NAN, p_value = NAN;
  std::string unit = {}, text = {};
};

std::string line(const Subject& s, const ReportedFigure& f) {
  std::string text = s.section + ',' + csv_cell(s.joint) + ',' + csv_cell(s.name) + ',' + csv_cell(f.figure);
  for (const double value : {f.value, f.lower, f.upper, f.p_value}) text += ',' + csv_number(value);
  return text + ',' + f.unit + ',' + csv_cell(f.text) + "\r\n";
}

std::vector<std::string> shape_names() {
  std::vector<std::string> names;
  for (const Shape shape : {Shape::step, Shape::hysteresis, Shape::exponential, Shape::line, Shape::order,
                            Shape::bump, Shape::by_count, Shape::noise, Shape::unknown})
    names.emplace_back(name(shape));
  return names;
}

/// The figures that are known; the ratio has an interval only if it was computed on held-out blocks.
std::string gain_lines(const Subject& subject, const Gain& g) {
  std::string lines;
  const Json gain = json_of(g);
  const ReportedFigure ratio{.figure = "ratio",
                             .value = g.ratio(),
                             .lower = g.held_out ? g.lower : NAN,
                             .upper = g.held_out ? g.upper : NAN,
                             .text = g.held_out ? "held out" : ""};
  for (const auto& [name, value] : gain.items())
    if (name == "ratio")
      lines += line(subject, ratio);
    else if (value.is_number() && name != "lower" && name != "upper")
      lines +=
          line(subject,
               {.figure = name, .value = value.get<double>(), .unit = name.starts_with("rms") ? g.unit : ""});
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
  const ReportedFigure begin =
      f.row    ? ReportedFigure{.figure = "row", .value = static_cast<double>(*f.row), .text = f.remedy}
      : f.time ? ReportedFigure{.figure = "time", .value = *f.time, .unit = "s", .text = f.remedy}
               : ReportedFigure{.text = f.remedy};
  return line(subject, begin) + line(subject, {.figure = "kind", .text = std::string(name(f.kind))});
}

}  // namespace

const Encoder* encoder_of(const Spec& spec, const std::string& joint) {
  const auto place = joint_place(spec, joint);
  return place ? &spec.model.transmission.encoders[*place] : nullptr;
}

std::string figure_unit(const Spec& spec, const Unidentified& u, const std::string& figure) {
  const std::string coordinate = coordinate_unit(spec, u.joint);
  if (figure == "time" || figure == "time_constant" || figure == "duration") return "s";
  if (figure == "frequency") return "Hz";
  if (figure == "divisor") return "counts";
  if (figure == "rate") return coordinate + "/s";
  if (figure == "order") return coordinate == "m" ? "1/m" : "";
  return coordinate;
}

DiagnosisReport diagnosis_report(const Spec& spec, Log log, const DiagnoseOptions& options,
                                 bool keep_values) {
  std::vector<Filter> filters;
  for (const NamedFilter& f : spec.filters)
    if (!f.controller) filters.push_back(f.filter);
  Log judged = keep_values ? log : std::move(log);
  if (!keep_values) log = described(judged);
  Diagnosis diagnosis = diagnose(spec.model, filters, spec.effects, std::move(judged), options);
  std::vector<std::string> warnings = spec.warnings;
  warnings.insert(warnings.end(), log.warnings.begin(), log.warnings.end());
  for (const std::string& text : diagnosis.warnings) add_once(warnings, text);
  return {spec, std::move(log), std::move(diagnosis), "", std::move(warnings)};
}

std::string coordinate_unit(const Spec& spec, const std::string& name) {
  if (const auto joint = joint_place(spec, name)) return spec.model.chain.independent[*joint].unit();
  for (const CoordinateInfo& row : coordinate_list())
    if (name == row.name || name == "tip." + std::string(row.name)) return std::string(row.unit);
  return "m";
}

std::vector<ReportedParameter> reported_parameters(const Spec& spec, const Cause& cause) {
  std::vector<ReportedParameter> list;
  const auto joint = joint_place(spec, cause.effect.joint);
  const bool prismatic = joint && spec.model.chain.independent[*joint].prismatic();
  const auto add = [&](const std::string& name, const std::string& unit) {
    for (const FoundParameter& p : cause.parameters)
      if (p.name == name) return list.push_back({p, unit, p.lower == p.upper});
    const auto number = cause.effect.numbers.find(name);
    if (number != cause.effect.numbers.end())
      list.push_back({{name, number->second, number->second, number->second}, unit, true});
  };
  const auto is_listed = [&](const std::string& name) {
    return std::ranges::any_of(list, [&](const auto& p) { return p.figure.name == name; });
  };
  for (const Parameter& row : effect_kind(cause.effect.type).parameters)
    add(std::string(row.name), unit_name(dimension_at(row, prismatic)));
  for (const FoundParameter& p : cause.parameters)
    if (!is_listed(p.name)) add(p.name, "");
  for (const auto& [name, value] : cause.effect.numbers)
    if (!is_listed(name)) add(name, "");
  return list;
}

std::string extended_model(const DiagnosisReport& r, const std::string& target) {
  const Diagnosis& d = r.diagnosis;
  const std::string& unit = d.gain.unit;
  std::string remarks = "qerr diagnose " + std::string(version()) + " of " + escaped(r.log.file) + ": " +
                        std::string(name(d.verdict));
  if (d.causes.empty()) return extended_spec(r.spec, {}, remarks + ", no effects to add", target);
  remarks += ", residual " + readable(d.gain.rms_before, unit) + " -> " + readable(d.gain.rms_after, unit) +
             (d.gain.held_out ? " (held out)" : "");
  const auto& columns = r.log.columns;
  const bool referenced =
      std::ranges::any_of(columns, [](const LogColumn& c) { return c.signal == LogSignal::reference; });
  std::vector<AddedEffect> effects;
  for (const Cause& cause : d.causes) {
    if (is_filter(cause.effect)) continue;
    // Readings that agree with their references are not late.
    if (referenced && cause.effect.joint == "tip" && effect_kind(cause.effect.type).stage == Stage::clock)
      remarks += "\nof the tracker's stamps, which a spec does not have: " + note(r.spec, cause);
    else
      effects.push_back({cause.effect, note(r.spec, cause)});
  }
  return extended_spec(r.spec, effects, remarks, target, found_filters(r));
}

RowsOf<Gain> rows(Of<Gain>) {
  return {{"held_out", &Gain::held_out, "measured on blocks of the log that the fit has not seen"},
          {"rms_before", &Gain::rms_before, nullable},
          {"rms_after", &Gain::rms_after, nullable},
          {"ratio", &Gain::ratio, nullable},
          {"lower", &Gain::lower, nullable},
          {"upper", &Gain::upper, nullable},
          {"counts_before", &Gain::counts_before, nullable},
          {"counts_after", &Gain::counts_after, nullable},
          {"sigma_ratio", &Gain::sigma_ratio, nullable},
          {"log_score", &Gain::log_score, nullable},
          {"coverage", &Gain::coverage, nullable},
          {"unit", &Gain::unit}};
}

RowsOf<ResidualCurve> rows(Of<ResidualCurve>) {
  return {{"against", &ResidualCurve::against, "the quantity on which the error depends"},
          {"unit", &ResidualCurve::unit, "of `at`"},
          {"at", &ResidualCurve::at, "centres of the bins"},
          {"residual", &ResidualCurve::residual, numbers_or_null(), "mean of the bin without this cause"},
          {"fit", &ResidualCurve::fit, numbers_or_null(), "mean contribution of this cause"}};
}

RowsOf<DataFinding> rows(Of<DataFinding>) {
  return {{"what", &DataFinding::what},
          {"kind", [](auto& f) { return name(f.kind); },
           one_of({"remark", "corrupt", "missing", "repeated", "contradictory"}),
           "of all but a remark --check ends with 1"},
          {"joint", &DataFinding::joint, "null: the whole record", nullable},
          {"row", &DataFinding::row, "of the file, from 1, where it begins", optional},
          {"time", &DataFinding::time, "[s], where it begins", optional},
          {"remedy", &DataFinding::remedy}};
}

RowsOf<Visible> rows(Of<Visible>) {
  return {{"effect", &Visible::effect},
          {"joint", &Visible::joint},
          {"parameter", &Visible::parameter, "whose smallest visible size is stated"},
          {"smallest", &Visible::smallest, "null: the record cannot show the effect", nullable},
          {"unit", &Visible::unit},
          {"hidden_by", &Visible::hidden_by, "why the record cannot show it", nullable}};
}

RowsOf<ReportedError> rows(Of<ReportedError>) {
  return {{"joint", &Unidentified::joint},
          {"what", &Unidentified::what},
          {"order", &Unidentified::order},
          {"frequency", &Unidentified::frequency},
          {"amplitude", &Unidentified::amplitude, nullable},
          {"unit", [](auto& u) { return coordinate_unit(u.whole.spec, u->joint); }},
          {"shape", [](auto& u) { return name(u->shape); }, one_of(shape_names())},
          {"figures", &Unidentified::figures, named_numbers_or_null(),
           "of the shape, SI, such as the time of a step"},
          {"units", figure_units, "of the figures"},
          {"curve", curve<ReportedError>}};
}

RowsOf<ReportedParameter> rows(Of<ReportedParameter>) {
  return {{"name", [](auto& p) { return p.figure.name; }},
          {"value", [](auto& p) { return p.figure.value; }},
          {"lower", [](auto& p) { return p.figure.lower; }, nullable},
          {"upper", [](auto& p) { return p.figure.upper; }, nullable},
          {"unit", &ReportedParameter::unit}};
}

RowsOf<ReportedCause> rows(Of<ReportedCause>) {
  return {
      {"effect", [](auto& c) { return c->effect.type; }},
      {"joint", [](auto& c) { return c->effect.joint; }},
      {"p_value", &Cause::p_value},
      {"parameters", [](auto& c) { return reported_parameters(c.whole.spec, *c); }, "with 95 % intervals"},
      {"gain", &Cause::gain, "of its joint"},
      {"rms", [](auto& c) { return only_if(c->rms > 0, c->rms); }, "of its contribution to the readings",
       optional},
      {"counts", counts, "the same in counts of the joint's encoder", optional},
      {"rms_without", &Cause::rms_without, "of the residual if the model lacks this cause alone", nullable},
      {"curve", curve<ReportedCause>},
      {"choices", [](auto& c) { return c->effect.choices; }, optional}};
}

RowsOf<LogColumn> rows(Of<LogColumn>) {
  return {{"column", &LogColumn::header},
          {"turns_at_start", [](auto& c) { return c.wraps.start; }},
          {"wraps", [](auto& c) { return c.wraps.count; }},
          {"first_row", [](auto& c) { return c.wraps.first_row; }},
          {"first_time", [](auto& c) { return c.wraps.first_time; }, nullable},
          {"contradicted", [](auto& c) { return c.wraps.contradicted; }}};
}

RowsOf<Log> rows(Of<Log>) {
  return {{"file", &Log::file},
          {"rows", &Log::rows},
          {"first_time", [](auto& l) { return only_if(l.has_time(), l.first_time); }},
          {"last_time", [](auto& l) { return only_if(l.has_time(), l.last_time); }},
          {"unwrapped", unwrapped, "columns that wrapped at a full turn"}};
}

RowsOf<Reproduction> rows(Of<Reproduction>) {
  return {
      {"rms_simulated", &Reproduction::rms_simulated, "of the extended model, simulated along the record"},
      {"rms_measured", &Reproduction::rms_measured},
      {"agrees", &Reproduction::agrees, "whether the simulation leaves what the gain says"}};
}

RowsOf<Comparison> rows(Of<Comparison>) {
  return {{"joint", &Comparison::joint},
          {"statistic", &Comparison::statistic},
          {"observed", &Comparison::observed, nullable},
          {"expected", &Comparison::expected, nullable},
          {"p_value", &Comparison::p_value, nullable}};
}

RowsOf<AlternativeCause> rows(Of<AlternativeCause>) {
  return {{"instead_of", &AlternativeCause::instead_of},
          {"effect", &AlternativeCause::effect},
          {"joint", &AlternativeCause::joint},
          {"record", &AlternativeCause::record}};
}

RowsOf<DiagnosisReport> rows(Of<DiagnosisReport>) {
  return header<DiagnosisReport>("diagnose")
      .with({{"spec", &DiagnosisReport::spec},
             {"log", &DiagnosisReport::log},
             {"seed", [](auto& r) { return r.spec.configurations.seed; }},
             {"verdict", [](auto& r) { return name(r.diagnosis.verdict); },
              one_of({"nothing_wrong", "explained", "partly_explained", "ambiguous", "unexplained",
                      "cannot_judge"})},
             {"reason", of_diagnosis(&Diagnosis::reason)},
             {"unjudged", of_diagnosis(&Diagnosis::unjudged),
              "joints (or tip, tip.x) of which the log has columns and nothing can be said: if any, --check "
              "ends with 1"},
             {"data", of_diagnosis(&Diagnosis::data), "faults of the record itself"},
             {"simulation", of_diagnosis(&Diagnosis::simulation),
              "statistics of the log, and of the simulated model"},
             {"causes", within(of_diagnosis(&Diagnosis::causes)),
              "in the order of the variance that they remove"},
             {"alternatives", of_diagnosis(&Diagnosis::alternatives),
              "what explains it as well, and what to record to tell"},
             {"unexplained", within(of_diagnosis(&Diagnosis::unexplained))},
             {"visible", of_diagnosis(&Diagnosis::visible), "what the record could have shown"},
             {"gain", of_diagnosis(&Diagnosis::gain), "of the extended model, over all judged joints"},
             {"check", of_diagnosis(&Diagnosis::check),
              "residual, reading - reference; null without a joint that is judged"},
             {"tip_check", of_diagnosis(&Diagnosis::tip_check),
              "the same of the tip, model - tracked [m]; null if no cause moves it"},
             {"extended_model", &DiagnosisReport::extended_model, "its file", nullable},
             {"warnings", &DiagnosisReport::warnings}});
}

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
