#include <algorithm>

#include "core/lists.hpp"
#include "core/run_files.hpp"
#include "core/text.hpp"
#include "input/csv.hpp"
#include "input/log_table.hpp"
#include "input/read_sections.hpp"
#include "input/spec_variants.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/kinematics/coordinates.hpp"

namespace qerr {

namespace {

/// Reads the spec with one step of a sweep. @returns its first fault, if any
std::optional<Fault> fault_of_variant(const Node& root, const std::string& file, const SweepStep& step) {
  SpecReader reader(file);
  Node variant = root;
  std::erase_if(variant.entries, [](const auto& entry) { return entry.key.name == "sweep"; });
  try {
    std::vector<SpecChange> changes;
    for (const auto& [key, value] : step.changes) changes.push_back(spec_change(key, value, file));
    apply_changes(variant, changes, reader.chain_of());
    reader.read(variant);
  } catch (const Error& e) {
    if (e.trouble() != Trouble::input) throw;
    return e.faults().front();
  }
  return std::nullopt;
}

/// Rejects a sweep of which the first and the last step of an axis both give a faulty spec: its key is wrong.
/// A single faulty value, such as a cut-off that reaches half the sample rate at the end of a range, is
/// reported by the sweep itself.
void check_sweep(const Node& root, const Spec& spec) {
  const Node* section = root.find("sweep");
  for (std::size_t i = 0; i < spec.sweep.size(); ++i) {
    const SweepAxis& axis = spec.sweep[i];
    const SweepStep& step = axis.steps.front();
    const auto first = fault_of_variant(root, spec.file, step);
    if (!first || !fault_of_variant(root, spec.file, axis.steps.back())) continue;
    throw Error(section->items[i].place, "sweep[" + std::to_string(i) + "]", first->key + ": " + first->rule,
                axis.keys.front() + " = '" + step.names.front() + "'", first->remedy);
  }
}

/// A robot given in place of its spec, which YAML reports as a misplaced `<`.
void refuse_xml(const std::string& text, const std::string& path) {
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  if (begin == std::string::npos || text[begin] != '<') return;
  const bool urdf = text.find("<robot") != std::string::npos;
  const bool xacro = text.find("<xacro:") != std::string::npos;
  throw Error({path, 1, 1}, "",
              std::string("this is ") +
                  (xacro  ? "a xacro file"
                   : urdf ? "a URDF"
                          : "XML") +
                  ", not a spec; a spec is YAML and names its URDF",
              quoted(text.substr(begin, std::min(text.find('\n', begin) - begin, std::size_t{40}))),
              xacro  ? "write a first spec: xacro " + path + " | qerr robot - --write-spec spec.yaml"
              : urdf ? "write a first spec: qerr robot " + path + " --write-spec spec.yaml"
                     : "begin with 'qerr: 1'");
}

/// Whether a key of the top level stands anywhere in a text, with its colon.
bool names_a_section(const std::string& text) {
  return std::ranges::any_of(spec_format::top, [&](const Parameter& p) {
    for (std::size_t at = 0; (at = text.find(p.name, at)) != std::string::npos; at += p.name.size())
      if (const std::size_t colon = text.find_first_not_of("\"' ", at + p.name.size());
          colon != std::string::npos && text[colon] == ':')
        return true;
    return false;
  });
}

/// Whether there is a line other than comments, which alone are an empty spec.
bool has_content(const std::string& text) {
  for (std::size_t at = 0; at < text.size(); at = text.find('\n', at)) {
    at = text.find_first_not_of(" \t\r\n", at);
    if (at == std::string::npos) return false;
    if (text[at] != '#') return true;
  }
  return false;
}

/// Files that are given in place of a spec. What they hold may be nobody's business: it is not repeated.
void refuse_other_files(const std::string& text, const std::string& path) {
  refuse_xml(text, path);
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  if (begin == std::string::npos) return;
  const auto has = [&](const char* key) { return text.find(key) != std::string::npos; };
  if (text[begin] == '{' && has("\"qerr\":") && has("\"command\":"))
    throw Error({path, 1, 1}, "", "this is a JSON report of qerr, not a spec", "",
                "give the spec of which it is; qerr compare takes reports");
  if (has_content(text) && !names_a_section(text))
    throw Error({path, 1, 1}, "", "this is no spec: it has none of the keys of one", "",
                "begin with 'qerr: 1' (qerr help spec)");
}

}  // namespace

Error unopened(const Field& f, const std::string& path, const Error& e) {
  const std::string written = f.node->text;
  const std::string remedy = written.find('\\') != std::string::npos ? "write paths with '/'"
                             : written.starts_with('~') || written.starts_with('$')
                                 ? "write the path out: ~ and variables are not expanded"
                                 : "give the path relative to the spec";
  return Error(f.node->place, f.path, e.faults().front().rule, "'" + path + "'", remedy,
               Trouble::file_system);
}

RobotOfSpec robot_of_spec(const std::string& text, const std::string& path) {
  refuse_other_files(text, path);
  return SpecReader(path).robot_of(parse_yaml(text, path));
}

Spec read_spec(const std::string& path, const SpecOverrides& overrides) {
  return parse_spec(read_text(path), path, overrides);
}

Spec parse_spec(const std::string& text, const std::string& path, const SpecOverrides& overrides) {
  refuse_other_files(text, path);
  Node root = parse_yaml(text, path);
  SpecReader reader(path);
  const std::vector<SpecChange> changes = spec_changes(overrides.values);
  std::vector<std::string> warnings;
  if (root.type == Node::Type::mapping) warnings = apply_changes(root, changes, reader.chain_of());
  Spec spec = reader.read(root);
  spec.warnings.insert(spec.warnings.begin(), warnings.begin(), warnings.end());
  check_sweep(root, spec);
  spec.text = text;
  spec.sha256 = sha256(text);
  spec.overrides = overrides.values;
  if (overrides.seed) spec.configurations.seed = *overrides.seed;
  return spec;
}

bool is_filtered(const NamedFilter& f, const Signal& s) {
  if (f.joints.empty()) return !is_closed(s);
  return s.kind && s.kind->joints && contains(f.joints, s.index);
}

std::vector<Filter> designed_filters(const Spec& spec) {
  std::vector<Filter> filters;
  for (const NamedFilter& f : spec.filters) filters.push_back(f.filter);
  return filters;
}

std::vector<Norms> filter_norms(const Spec& spec) {
  std::vector<Norms> norms;
  for (const NamedFilter& f : spec.filters) norms.push_back(f.norms);
  return norms;
}

}  // namespace qerr

/// Reads the sections `coordinates`, `log` and `threshold` of a spec.
namespace qerr {

std::string of_which_tip(const OperationalModel& model, const std::string& coordinate) {
  return "write " + model.tips->front().name + '.' + coordinate +
         (model.tips->size() > 1 ? " or " + (*model.tips)[1].name + '.' + coordinate : "") +
         "; tips have x y z rx ry rz";
}

void add_length(Coordinate length, OperationalModel& model) {
  if (contains(model.lengths, length)) return;
  for (int k = 0; k < 3; ++k) {
    const auto component = static_cast<Coordinate>(static_cast<int>(first_component(length)) + k);
    add_once(model.coordinates, component);
  }
  model.lengths.push_back(length);
}

void add_signal(const Signal& signal, OperationalModel& model) {
  if (!find_named(model.signals, signal.name)) model.signals.push_back(signal);
}

void add_positions_of_tips(OperationalModel& model) {
  for (const NamedTip& tip : *model.tips)
    for (const Coordinate c : {Coordinate::x, Coordinate::y, Coordinate::z})
      if (tip.name.find('-') == std::string::npos)  // of one relative to another
        for (const Signal& s : find_signals(model, tip.name + '.' + std::string(info(c).name)))
          add_signal(s, model);
}

void read_coordinates(const Field& f, Spec& spec) {
  std::vector<std::string> all;
  if (!spec.model.tips) all = names_of(coordinate_list());
  append(all, signal_names(spec.model));
  std::vector<std::string> named;
  std::vector<Coordinate> lengths;
  OperationalModel& model = spec.model;
  model.coordinates.clear();
  for (const Field& item : read_list(f, "[x, y, z]")) {
    const std::string name = read_text_value(item);
    const auto coordinate = find_coordinate(name);
    if (coordinate && model.tips) item.refuse("which of the tips is not said", of_which_tip(model, name));
    const std::vector<Signal> signals =
        coordinate ? std::vector{signal_of(*coordinate)} : find_signals(model, name);
    if (signals.empty()) item.refuse("no such coordinate", did_you_mean(name, all));
    for (const Signal& s : signals) {
      if (contains(named, s.name)) item.refuse("duplicate coordinate", "keep one of them");
      named.push_back(s.name);
      if (!s.coordinate)
        add_signal(s, model);
      else
        (is_length(*s.coordinate) ? lengths : model.coordinates).push_back(*s.coordinate);
    }
  }
  if (named.empty()) f.refuse("the list of coordinates is empty", "write [x, y, z], or leave the key out");
  for (const Coordinate c : lengths) add_length(c, model);
}

namespace {

/// A header, or `{column: HEADER, unit: UNIT}`.
LogSource read_log_source(const std::string& signal, const Field& f) {
  if (f.node->type != Node::Type::mapping) return {signal, read_text_value(f), {}};
  const Object o(f, spec_format::log_column);
  const std::string unit = o.text("unit").value_or("");
  std::string why;
  if (!unit.empty() && !parse_unit(unit, why)) o.at("unit").refuse(why, "such as deg, mm or ms");
  return {signal, *o.text("column"), unit};
}

}  // namespace

void read_log_section(const Field& f, Spec& spec) {
  const Object o(f, spec_format::log);
  const std::string missing = o.choice("missing");
  spec.log.missing = missing == "drop"   ? MissingValues::drop
                     : missing == "hold" ? MissingValues::hold
                                         : MissingValues::error;
  if (o.has("time")) spec.log.columns.push_back(read_log_source("time", o.at("time")));
  if (!o.has("columns")) return;
  for (const auto& [key, value] : read_map(o.at("columns"))) {
    require_log_signal(key.name, key.place, value.path, spec.model.chain);
    for (const LogSource& other : spec.log.columns)
      if (other.signal == key.name) value.refuse("duplicate signal", "keep one of them");
    spec.log.columns.push_back(read_log_source(key.name, value));
  }
}

void read_threshold(const Field& f, Spec& spec) {
  spec.threshold_length = Object(f, spec_format::threshold).number("length");
  warn_of_bare_numbers(f, spec_format::threshold, {}, spec.warnings);
}

}  // namespace qerr
