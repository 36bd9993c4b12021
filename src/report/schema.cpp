#include <cmath>

#include "input/read_sections.hpp"
#include "qerr/core/parameter.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/encoder/encoder.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/kinematics/coordinates.hpp"
#include "qerr/report/write.hpp"
#include "report/formats.hpp"
#include "simulate/estimators/estimator.hpp"

/// The schema is made from the rows that the reader of the spec uses; names of joints, stability and limits
/// are checked by the reader alone.
namespace qerr {

namespace {

/// Text with a number and a unit.
Json quantity() {
  return {{"type", "string"}, {"pattern", "^[+-]?(0|[1-9][0-9]*)?\\.?[0-9]*([eE][+-]?[0-9]+)? *[^ ].*$"}};
}

Json any_of(const std::vector<Json>& schemas) { return {{"anyOf", schemas}}; }

Json number_or_quantity() { return any_of({Json({{"type", "number"}}), quantity()}); }

Json non_empty_list_of(Json items) {
  return {{"type", "array"}, {"minItems", 1}, {"items", std::move(items)}};
}
Json required(const std::vector<std::string>& names) { return {{"required", names}}; }

/// A bare number within the row's range and that of physics, or text with a number and a unit (whose range
/// only the reader can judge). Of a joint coordinate the range of angles, as it includes that of lengths.
Json of_number(const Parameter& row) {
  const Parameter p = with_physical_range(row, dimension::angle);
  Json bare = {{"type", p.kind == Kind::integer ? "integer" : "number"}};
  if (std::isfinite(p.least)) bare[p.open_below ? "exclusiveMinimum" : "minimum"] = p.least;
  if (std::isfinite(p.most)) bare[p.open_above ? "exclusiveMaximum" : "maximum"] = p.most;
  if (p.kind == Kind::integer) return bare;
  return any_of({bare, quantity()});
}

Json of_row(const Parameter& p) {
  Json s;
  switch (p.kind) {
    case Kind::number:
    case Kind::integer:
      s = of_number(p);
      break;
    case Kind::boolean:
      s = {{"type", "boolean"}};
      break;
    case Kind::text:
      s = {{"type", "string"}, {"minLength", 1}};
      break;
    case Kind::choice:
      s = {{"enum", choices_of(p)}};
      break;
    case Kind::numbers:
      s = {{"type", "array"}, {"items", number_or_quantity()}, {"minItems", 1}};
      break;
    case Kind::matrix:
      s = any_of({number_or_quantity(),
                  schema::list(any_of({number_or_quantity(), schema::list(number_or_quantity())}))});
      break;
    case Kind::object:
    case Kind::map:
      s = {{"type", "object"}};
      break;
    case Kind::objects:
      s = schema::list({{"type", "object"}});
      break;
    case Kind::any:
      s = Json::object();
      break;
  }
  std::string meaning(p.meaning);
  if (const std::string unit = parameter_unit(p); !unit.empty()) meaning += " [" + unit + "]";
  if (!meaning.empty()) s["description"] = meaning;
  if (p.fallback) s["default"] = *p.fallback;
  return s;
}

Json object_of(const std::vector<Parameter>& rows) {
  Json s = {{"type", "object"}, {"additionalProperties", false}, {"properties", Json::object()}};
  for (const Parameter& p : rows) {
    s["properties"][std::string(p.name)] = of_row(p);
    if (p.required) s["required"].push_back(p.name);
  }
  return s;
}

/// The schema of a key in full, in place of what its row says but its description.
void refine(Json& object, const char* key, Json full) {
  Json& row = object["properties"][key];
  full["description"] = row["description"];
  row = std::move(full);
}

std::vector<Parameter> with_more(std::vector<Parameter> rows, const std::vector<Parameter>& more) {
  rows.insert(rows.end(), more.begin(), more.end());
  return rows;
}

/// One of several kinds, which a key names. @param common  parameters of all
template <class Kinds>
Json one_of_kinds(const Kinds& kinds, const std::vector<Parameter>& common, const char* key) {
  Json all = Json::array();
  for (const auto& kind : kinds) {
    Json s = object_of(with_more(common, kind.parameters));
    s["properties"][key] = {{"const", kind.name}, {"description", kind.summary}};
    all.push_back(s);
  }
  return {{"oneOf", all}};
}

Json encoder() {
  Json kinds = Json::array();
  for (const EncoderKind& kind : encoder_kinds()) kinds.push_back(object_of(encoder_parameters(kind)));
  return {{"oneOf", kinds}};
}

Json filter() {
  Json s = object_of(spec_format::filter());
  refine(s, "lowpass", one_of_kinds(filter_families(), spec_format::lowpass, "family"));
  s["anyOf"] = Json::array({required({"derivative"}), required({"lowpass"})});
  std::vector<Json> representations{required({"lowpass"})};
  for (const FilterRepresentation& r : filter_representations()) {
    const std::string key(r.key.name);
    if (!r.inside.empty()) refine(s, key.c_str(), object_of(r.inside));
    const Json stated = required({key});
    s["anyOf"].push_back(stated);
    for (const Parameter& p : r.beside) {
      s["dependencies"][std::string(p.name)] = Json::array({key});
      if (p.required) s["dependencies"][key].push_back(p.name);
    }
    // A filter has one representation.
    for (const Json& other : representations)
      s["not"]["anyOf"].push_back({{"allOf", Json::array({stated, other})}});
    representations.push_back(stated);
  }
  return s;
}

Json configurations() {
  Json s = object_of(spec_format::configurations);
  refine(s, "limits",
         schema::map({{"type", "array"}, {"items", number_or_quantity()}, {"minItems", 2}, {"maxItems", 2}}));
  refine(s, "points", non_empty_list_of(schema::list(number_or_quantity())));
  return s;
}

Json motion() {
  Json joint = object_of(spec_format::joint_motion);
  refine(joint, "sines", schema::list(object_of(spec_format::sine)));
  refine(joint, "moves", non_empty_list_of(object_of(spec_format::move)));
  for (const char* key : {"sines", "velocity"}) joint["dependencies"][key] = {{"not", required({"moves"})}};
  Json s = object_of(spec_format::motion);
  refine(s, "joints", schema::map(joint));
  s["oneOf"] = Json::array({required({"joints", "sample_rate", "duration"}), required({"file"})});
  return s;
}

Json sweep() {
  Json s = object_of(spec_format::sweep);
  for (const char* key : {"from", "to"}) refine(s, key, number_or_quantity());
  refine(s, "keys", non_empty_list_of({{"type", "string"}}));
  refine(s, "values",
         non_empty_list_of({{"type", Json::array({"number", "string", "boolean", "array", "object"})}}));
  s["oneOf"] = Json::array({required({"key", "values"}), required({"key", "from", "to", "count"}),
                            required({"keys", "values"}), required({"key", "catalogue"})});
  return s;
}

/// Every key of an encoder may be a value, a list or a range.
Json design_encoder() {
  Json s = {{"type", "object"}, {"additionalProperties", false}, {"properties", Json::object()}};
  for (const EncoderKind& kind : encoder_kinds())
    for (const Parameter& row : encoder_parameters(kind))
      s["properties"][std::string(row.name)] = {{"description", of_row(row)["description"]}};
  s["properties"]["catalogue"] = {{"type", "string"},
                                  {"description", "path of a CSV file, relative to this file"}};
  s["properties"]["price"] = {{"description", "of each value, or {fixed, per_bit}"}};
  s["properties"]["price"]["if"] = {{"type", "object"}};
  s["properties"]["price"]["then"] = {
      {"additionalProperties", false},
      {"properties",
       {{"fixed", {{"type", "number"}, {"minimum", 0}, {"description", "of an encoder, whatever its bits"}}},
        {"per_bit", {{"type", "number"}, {"minimum", 0}, {"description", "added for each bit"}}}}}};
  s["properties"]["gear_price"] = {{"description", "of each gear_ratio"}};
  return s;
}

Json design() {
  Json filter = object_of(spec_format::design_filter);
  refine(filter, "tracking", object_of(spec_format::design_tracking));
  Json s = object_of(spec_format::design);
  refine(s, "encoders", schema::map(design_encoder()));
  refine(s, "filters", schema::map(filter));
  refine(s, "gains", schema::map(object_of(spec_format::design_gains)));
  return s;
}

Json control() {
  Json joint = object_of(spec_format::controller);
  for (const char* key : {"kp", "kd", "inertia", "damping", "friction"})
    refine(joint, key, number_or_quantity());
  Json s = object_of(spec_format::control);
  refine(s, "joints", schema::map(joint));
  Json tip = object_of(spec_format::tip_impedance);
  for (const char* key : {"stiffness", "damping"})
    tip["properties"][key]["minItems"] = tip["properties"][key]["maxItems"] = 3;
  refine(s, "tip", tip);
  return s;
}

Json wall() {
  Json s = object_of(spec_format::wall);
  s["properties"]["normal"]["minItems"] = s["properties"]["normal"]["maxItems"] = 3;
  return s;
}

Json pose() {
  Json s = object_of(spec_format::pose);
  for (const char* key : {"xyz", "rpy"})
    s["properties"][key]["minItems"] = s["properties"][key]["maxItems"] = 3;
  return s;
}

}  // namespace

std::string json_schema() {
  Json s = object_of(spec_format::top);
  Json root = {{"$schema", "http://json-schema.org/draft-07/schema#"},
               {"$id", "urn:qerr:spec:1"},
               {"title", "qerr spec, version 1"}};
  Json names = Json::array();
  for (const CoordinateInfo& c : coordinate_list()) names.push_back(c.name);
  for (const SignalKind& kind : signal_kinds()) names.push_back(kind.group);
  Json robot = object_of(spec_format::robot);
  for (const char* key : {"tool", "tracker"}) refine(robot, key, pose());
  refine(robot, "tips", schema::map({{"type", "string"}}));
  refine(robot, "joint", object_of(spec_format::joint));
  refine(robot, "dh", non_empty_list_of(object_of(spec_format::dh_row)));
  for (const char* key : {"urdf", "joint", "dh"})
    robot["oneOf"].push_back({{"required", Json::array({key})}});
  refine(s, "robot", robot);
  refine(s, "encoders", schema::map(encoder()));
  refine(s, "coupling", non_empty_list_of(schema::list(number_or_quantity())));
  refine(s, "coordinates",
         {{"type", "array"},
          {"minItems", 1},
          {"uniqueItems", true},
          {"items", {{"type", "string"}, {"examples", names}}}});
  refine(s, "filters", schema::map(filter()));
  refine(s, "estimators", schema::map(one_of_kinds(estimator_kinds(), spec_format::estimator, "kind")));
  refine(s, "configurations", configurations());
  Json requirement = object_of(spec_format::requirement());
  for (const char* key : {"at_most", "at_least"}) refine(requirement, key, number_or_quantity());
  requirement["oneOf"] = Json::array({required({"at_most"}), required({"at_least"})});
  refine(s, "requirements", schema::list(requirement));
  refine(s, "threshold", object_of(spec_format::threshold));
  refine(s, "motion", motion());
  refine(s, "effects", schema::list(one_of_kinds(effect_kinds(), spec_format::effect, "type")));
  Json log = object_of(spec_format::log);
  const Json column =
      any_of({Json({{"type", "string"}, {"minLength", 1}}), object_of(spec_format::log_column)});
  refine(log, "time", column);
  refine(log, "columns", schema::map(column));
  refine(s, "log", log);
  refine(s, "control", control());
  refine(s, "walls", schema::map(wall()));
  refine(s, "sweep", schema::list(sweep()));
  refine(s, "design", design());
  root.update(s);
  return document(root);
}

}  // namespace qerr
