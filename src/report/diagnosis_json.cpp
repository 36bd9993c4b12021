#include <cmath>
#include <nlohmann/json.hpp>

#include "diagnosis_writers.hpp"

namespace qerr {

namespace {

using Json = nlohmann::ordered_json;

/// JSON has no infinity: a figure that is not known, or has no bound, is null.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json optional_number(const std::optional<double>& value) { return value ? number(*value) : Json(nullptr); }

Json gain(const Gain& g, const std::string& unit) {
  return {{"held_out", g.held_out},
          {"rms_before", number(g.rms_before)},
          {"rms_after", number(g.rms_after)},
          {"ratio", number(g.ratio())},
          {"lower", number(g.lower)},
          {"upper", number(g.upper)},
          {"counts_before", number(g.counts_before)},
          {"counts_after", number(g.counts_after)},
          {"sigma_ratio", number(g.sigma_ratio)},
          {"log_score", number(g.log_score)},
          {"coverage", number(g.coverage)},
          {"unit", unit}};
}

Json simulation(const Diagnosis& d) {
  Json list = Json::array();
  for (const Comparison& c : d.simulation)
    list.push_back({{"joint", c.joint},
                    {"statistic", c.statistic},
                    {"observed", number(c.observed)},
                    {"expected", number(c.expected)},
                    {"p_value", number(c.p_value)}});
  return list;
}

Json causes(const DiagnosisReport& r) {
  Json list = Json::array();
  for (const Cause& c : r.diagnosis.causes) {
    Json parameters = Json::array();
    for (const ReportedParameter& p : reported_parameters(r.spec, c))
      parameters.push_back({{"name", p.figure.name},
                            {"value", number(p.figure.value)},
                            {"lower", number(p.figure.lower)},
                            {"upper", number(p.figure.upper)},
                            {"unit", p.unit}});
    Json entry = {{"effect", c.effect.type},
                  {"joint", c.effect.joint},
                  {"p_value", number(c.p_value)},
                  {"parameters", parameters},
                  {"gain", gain(c.gain, coordinate_unit(r.spec, c.effect.joint))}};
    if (c.rms > 0) entry["rms"] = number(c.rms);
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
  for (const Unnamed& u : r.diagnosis.unexplained)
    list.push_back({{"joint", u.joint},
                    {"what", u.what},
                    {"order", optional_number(u.order)},
                    {"frequency", optional_number(u.frequency)},
                    {"amplitude", number(u.amplitude)},
                    {"unit", coordinate_unit(r.spec, u.joint)}});
  return list;
}

Json log(const Log& l) {
  Json unwrapped = Json::array();
  for (const LogColumn& c : l.columns)
    if (c.wraps.count > 0 || c.wraps.start != 0)
      unwrapped.push_back({{"column", c.header},
                           {"turns_at_start", c.wraps.start},
                           {"wraps", c.wraps.count},
                           {"first_row", c.wraps.first_row},
                           {"first_time", number(c.wraps.first_time)},
                           {"contradicted", c.wraps.contradicted}});
  return {{"file", l.file},
          {"rows", l.rows},
          {"first_time", l.has_time() ? number(l.first_time) : Json(nullptr)},
          {"last_time", l.has_time() ? number(l.last_time) : Json(nullptr)},
          {"unwrapped", unwrapped}};
}

}  // namespace

std::string to_json(const DiagnosisReport& r) {
  Json source = {{"file", r.spec.file}, {"sha256", r.spec.sha256}};
  for (const auto& [key, value] : r.spec.overrides) source["set"].push_back({{"key", key}, {"value", value}});
  const Diagnosis& d = r.diagnosis;
  return Json{{"qerr", version()},
              {"command", "diagnose"},
              {"spec", source},
              {"log", log(r.log)},
              {"seed", r.spec.configurations.seed},
              {"verdict", name(d.verdict)},
              {"reason", d.reason},
              {"simulation", simulation(d)},
              {"causes", causes(r)},
              {"alternatives", alternatives(d)},
              {"unexplained", unexplained(r)},
              {"gain", gain(d.gain, gain_unit(d))},
              {"extended_model", r.extended_model.empty() ? Json(nullptr) : Json(r.extended_model)},
              {"warnings", r.warnings}}
             .dump(2) +
         "\n";
}

}  // namespace qerr
