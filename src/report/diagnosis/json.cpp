#include "report/diagnosis/parts.hpp"
#include "report/formats.hpp"
#include "report/json_header.hpp"

namespace qerr {

namespace {

Json gain(const Gain& g) {
  return {{"held_out", g.held_out},
          {"rms_before", g.rms_before},
          {"rms_after", g.rms_after},
          {"ratio", g.ratio()},
          {"lower", g.lower},
          {"upper", g.upper},
          {"counts_before", g.counts_before},
          {"counts_after", g.counts_after},
          {"sigma_ratio", g.sigma_ratio},
          {"log_score", g.log_score},
          {"coverage", g.coverage},
          {"unit", g.unit}};
}

Json simulation(const Diagnosis& d) {
  Json list = Json::array();
  for (const Comparison& c : d.simulation)
    list.push_back({{"joint", c.joint},
                    {"statistic", c.statistic},
                    {"observed", c.observed},
                    {"expected", c.expected},
                    {"p_value", c.p_value}});
  return list;
}

/// Null without bins.
Json curve(const ResidualCurve& c) {
  if (c.at.empty()) return nullptr;
  return {{"against", c.against}, {"unit", c.unit}, {"at", c.at}, {"residual", c.residual}, {"fit", c.fit}};
}

Json causes(const DiagnosisReport& r) {
  Json list = Json::array();
  for (const Cause& c : r.diagnosis.causes) {
    Json parameters = Json::array();
    for (const ReportedParameter& p : reported_parameters(r.spec, c))
      parameters.push_back({{"name", p.figure.name},
                            {"value", p.figure.value},
                            {"lower", p.figure.lower},
                            {"upper", p.figure.upper},
                            {"unit", p.unit}});
    Json entry = {{"effect", c.effect.type},
                  {"joint", c.effect.joint},
                  {"p_value", c.p_value},
                  {"parameters", parameters},
                  {"gain", gain(c.gain)}};
    if (c.rms > 0) entry["rms"] = c.rms;
    if (const Encoder* encoder = encoder_of(r.spec, c.effect.joint); encoder && c.rms > 0)
      entry["counts"] = c.rms / encoder->resolution;
    entry["rms_without"] = c.rms_without;
    entry["curve"] = curve(c.curve);
    if (!c.effect.choices.empty()) entry["choices"] = c.effect.choices;
    list.push_back(entry);
  }
  return list;
}

Json alternatives(const Diagnosis& d) {
  Json list = Json::array();
  for (const AlternativeCause& a : d.alternatives)
    list.push_back(
        {{"instead_of", a.instead_of}, {"effect", a.effect}, {"joint", a.joint}, {"record", a.record}});
  return list;
}

Json unexplained(const DiagnosisReport& r) {
  Json list = Json::array();
  for (const Unidentified& u : r.diagnosis.unexplained) {
    Json figures = Json::object(), units = Json::object();
    for (const auto& [key, value] : u.figures) {
      figures[key] = value;
      units[key] = figure_unit(r.spec, u, key);
    }
    list.push_back({{"joint", u.joint},
                    {"what", u.what},
                    {"order", u.order},
                    {"frequency", u.frequency},
                    {"amplitude", u.amplitude},
                    {"unit", coordinate_unit(r.spec, u.joint)},
                    {"shape", name(u.shape)},
                    {"figures", figures},
                    {"units", units},
                    {"curve", curve(u.curve)}});
  }
  return list;
}

Json null_if_empty(const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); }

/// Each with the row or the time at which it begins, or with neither.
Json data(const Diagnosis& d) {
  Json list = Json::array();
  for (const DataFinding& f : d.data) {
    Json entry = {{"what", f.what}, {"kind", name(f.kind)}, {"joint", null_if_empty(f.joint)}};
    if (f.row) entry["row"] = *f.row;
    if (f.time) entry["time"] = *f.time;
    entry["remedy"] = f.remedy;
    list.push_back(entry);
  }
  return list;
}

Json visible(const Diagnosis& d) {
  Json list = Json::array();
  for (const Visible& v : d.visible)
    list.push_back({{"effect", v.effect},
                    {"joint", v.joint},
                    {"parameter", v.parameter},
                    {"smallest", v.smallest},
                    {"unit", v.unit},
                    {"hidden_by", null_if_empty(v.hidden_by)}});
  return list;
}

/// Null without a joint that is judged.
Json check(const Diagnosis& d) {
  if (!d.check) return nullptr;
  return {{"rms_simulated", d.check->rms_simulated},
          {"rms_measured", d.check->rms_measured},
          {"agrees", d.check->agrees}};
}

Json log(const Log& l) {
  Json unwrapped = Json::array();
  for (const LogColumn& c : l.columns)
    if (c.wraps.count > 0 || c.wraps.start != 0)
      unwrapped.push_back({{"column", c.header},
                           {"turns_at_start", c.wraps.start},
                           {"wraps", c.wraps.count},
                           {"first_row", c.wraps.first_row},
                           {"first_time", c.wraps.first_time},
                           {"contradicted", c.wraps.contradicted}});
  return {{"file", l.file},
          {"rows", l.rows},
          {"first_time", l.has_time() ? l.first_time : Json(nullptr)},
          {"last_time", l.has_time() ? l.last_time : Json(nullptr)},
          {"unwrapped", unwrapped}};
}

}  // namespace

std::string to_json(const DiagnosisReport& r, const Style&) {
  const Diagnosis& d = r.diagnosis;
  return Json{{"qerr", version()},
              {"command", "diagnose"},
              {"spec", spec_source(r.spec)},
              {"log", log(r.log)},
              {"seed", r.spec.configurations.seed},
              {"verdict", name(d.verdict)},
              {"reason", d.reason},
              {"unjudged", d.unjudged},
              {"data", data(d)},
              {"simulation", simulation(d)},
              {"causes", causes(r)},
              {"alternatives", alternatives(d)},
              {"unexplained", unexplained(r)},
              {"visible", visible(d)},
              {"gain", gain(d.gain)},
              {"check", check(d)},
              {"extended_model", r.extended_model.empty() ? Json(nullptr) : Json(r.extended_model)},
              {"warnings", r.warnings}}
      .document();
}

}  // namespace qerr
