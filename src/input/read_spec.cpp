#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/sha256.hpp"
#include "core/text.hpp"
#include "input/override.hpp"
#include "input/package_path.hpp"
#include "input/read_sections.hpp"
#include "input/read_text.hpp"
#include "input/spec_format.hpp"
#include "input/unknown_key.hpp"
#include "qerr/input/read_urdf.hpp"

namespace qerr {

namespace {

/// A longer link suggests a URDF in millimetres: no robot has a link of 20 m, and few have one below 20 mm.
constexpr double longest_link = 20;  // [m]

void warn_about_units(const Chain& chain, std::vector<std::string>& warnings) {
  double longest = chain.tip_offset.translation().norm();
  for (const ChainJoint& joint : chain.joints) longest = std::max(longest, joint.origin.translation().norm());
  if (longest > longest_link)
    warnings.push_back("a link is " + shortest(longest) + " m long: is the URDF in millimetres?");
}

class SpecReader {
 public:
  SpecReader(const std::string& path)
      : folder_(path == "-" ? "." : std::filesystem::path(path).parent_path().string()) {
    spec_.file = path;
  }

  Spec read(const Node& root) {
    if (root.type != Node::Type::mapping)
      throw Error({root.place, "", "a spec must be a mapping", described(root), "begin with 'qerr: 1'"});
    const Object top = checked_top(root);
    read_chain(top.at("robot"));
    faults_.raise();  // all further sections refer to the joints of the chain
    section(top, "encoders", [&](const Field& f) { read_encoders(f, robot_, spec_, faults_); });
    if (!faults_.any()) warn_of_stated_ratios(robot_, spec_);
    section(top, "coupling", [&](const Field& f) { read_coupling(f, spec_); });
    spec_.model.coordinates = {Coordinate::x, Coordinate::y, Coordinate::z};
    section(top, "coordinates", [&](const Field& f) { read_coordinates(f, spec_); });
    faults_.guard([&] {
      if (top.choice("frame") == "tip") spec_.model.frame = CoordinateFrame::tip;
    });
    section(top, "filters", [&](const Field& f) { read_filters(f, spec_, faults_); });
    faults_.guard([&] { read_configurations(top.at("configurations"), folder_, robot_, spec_, faults_); });
    section(top, "threshold", [&](const Field& f) { read_threshold(f, spec_); });
    section(top, "motion", [&](const Field& f) { read_motion(f, folder_, robot_, spec_, faults_); });
    section(top, "effects", [&](const Field& f) { read_effects(f, robot_, spec_, faults_); });
    section(top, "sweep", [&](const Field& f) { read_sweep(f, spec_, faults_); });
    if (!spec_.sweep.empty())
      spec_.warnings.emplace_back(
          "sweep: is not used by this command: its figures are those of the spec's own values");
    faults_.raise();  // requirements refer to coordinates and filters
    section(top, "requirements", [&](const Field& f) { read_requirements(f, spec_, faults_); });
    faults_.raise();
    return std::move(spec_);
  }

 private:
  /// Unknown keys are reported together with the faults of the known sections, unless a required section is
  /// missing.
  Object checked_top(const Node& root) {
    const Field field{&root, ""};
    std::vector<Parameter> format = spec_format::top();
    if (!faults_.guard([&] { Object(field, format); })) {
      raise_if_not_indented(root, format);
      for (const auto& [key, value] : root.entries) format.push_back({.name = key.name, .kind = Kind::any});
      for (Parameter& row : format) {
        if (row.required && !root.find(row.name)) faults_.raise();
        row.required = false;
      }
    }
    Object top(field, format);
    faults_.guard([&] { check_version(top); });
    return top;
  }

  static void check_version(const Object& top) {
    if (!top.has("qerr")) return;
    try {
      top.number("qerr");
    } catch (const Error&) {
      throw Error(top.at("qerr").fault("is the version of the format, and this program reads version 1",
                                       "write 'qerr: 1'"));
    }
  }

  /// Entries that are not indented below their section leave it empty: one mistake.
  void raise_if_not_indented(const Node& root, const std::vector<Parameter>& format) {
    for (const auto& entry : root.entries) {
      const bool known = std::any_of(format.begin(), format.end(),
                                     [&](const Parameter& row) { return row.name == entry.key.name; });
      if (!known && empty_section_before(root, entry)) faults_.raise();
    }
  }

  template <class Read>
  void section(const Object& top, std::string_view key, Read read) {
    if (top.has(key)) faults_.guard([&] { read(top.at(key)); });
  }

  void read_chain(const Field& f) {
    faults_.guard([&] {
      const Object o(f, spec_format::robot());
      const Field urdf = o.at("urdf");
      const std::string path = find_urdf(urdf, *o.text("urdf"));
      read_named_file(urdf, path, [&](const std::string& file) { robot_ = read_urdf(file); });
      spec_.robot_name = robot_.name;
      try {
        spec_.model.chain = make_chain(robot_, o.text("base").value_or(""), o.text("tip").value_or(""));
        spec_.warnings = warnings_about(robot_, spec_.model.chain);
      } catch (const Error& e) {
        throw placed(e, f);
      }
      if (o.has("tool"))
        spec_.model.chain.tip_offset = spec_.model.chain.tip_offset * read_tool(o.at("tool"));
      warn_about_units(spec_.model.chain, spec_.warnings);
    });
  }

  std::string find_urdf(const Field& urdf, const std::string& given) const {
    try {
      return urdf_path(given, folder_);
    } catch (const Error& e) {
      Fault fault = e.faults().front();
      fault.place = urdf.node->place;
      fault.key = urdf.path;
      throw Error(fault);
    }
  }

  /// Gives faults about `robot.base` and `robot.tip` their place in the spec instead of the URDF.
  static Error placed(const Error& e, const Field& robot) {
    std::vector<Fault> faults = e.faults();
    for (Fault& fault : faults) {
      if (!fault.key.starts_with("robot.")) continue;
      const Node* value = robot.node->find(std::string_view(fault.key).substr(6));
      fault.place = value ? value->place : robot.node->place;
    }
    return Error(faults, e.trouble());
  }

  std::string folder_;
  RobotModel robot_;
  Spec spec_;
  Faults faults_;
};

/// Reads the spec with one value of a sweep. @returns its first fault, if any
std::optional<Fault> fault_of_variant(const Node& root, const std::string& file, const SweepAxis& axis,
                                      const std::string& value) {
  Node variant = root;
  std::erase_if(variant.entries, [](const auto& entry) { return entry.key.name == "sweep"; });
  try {
    apply_override(variant, axis.key, value, file);
    SpecReader(file).read(variant);
  } catch (const Error& e) {
    return e.faults().front();
  }
  return std::nullopt;
}

/// Rejects a sweep whose first and last value both give a faulty spec: its key is wrong. A single faulty
/// value, such as a cut-off that reaches half the sample rate at the end of a range, is reported by the sweep
/// itself.
void check_sweep(const Node& root, const Spec& spec) {
  const Node* section = root.find("sweep");
  for (std::size_t i = 0; i < spec.sweep.size(); ++i) {
    const SweepAxis& axis = spec.sweep[i];
    const auto first = fault_of_variant(root, spec.file, axis, axis.values.front());
    if (!first || !fault_of_variant(root, spec.file, axis, axis.values.back())) continue;
    throw Error({section->items[i].place, "sweep[" + std::to_string(i) + "]", first->key + ": " + first->rule,
                 axis.key + " = '" + axis.values.front() + "'", first->remedy});
  }
}

/// A robot given in place of its spec, which YAML reports as a misplaced `<`.
void refuse_xml(const std::string& text, const std::string& path) {
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  if (begin == std::string::npos || text[begin] != '<') return;
  const bool urdf = text.find("<robot") != std::string::npos;
  const bool xacro = text.find("<xacro:") != std::string::npos;
  throw Error(Fault{{path, 1, 1},
                    "",
                    std::string("this is ") +
                        (xacro  ? "a xacro file"
                         : urdf ? "a URDF"
                                : "XML") +
                        ", not a spec; a spec is YAML and names its URDF",
                    quoted(text.substr(begin, std::min(text.find('\n', begin) - begin, std::size_t{40}))),
                    xacro  ? "write a first spec: xacro " + path + " | qerr robot - --write-spec spec.yaml"
                    : urdf ? "write a first spec: qerr robot " + path + " --write-spec spec.yaml"
                           : "begin with 'qerr: 1'"});
}

}  // namespace

Error unopened(const Field& f, const std::string& path, const Error& e) {
  const std::string written = f.node->text;
  const std::string remedy = written.find('\\') != std::string::npos ? "write paths with '/'"
                             : written.starts_with('~') || written.starts_with('$')
                                 ? "write the path out: ~ and variables are not expanded"
                                 : "give the path relative to the spec";
  return Error(Fault{f.node->place, f.path, e.faults().front().rule, "'" + path + "'", remedy},
               Trouble::file_system);
}

Spec read_spec(const std::string& path, const SpecOverrides& overrides) {
  return parse_spec(read_text(path), path, overrides);
}

Spec parse_spec(const std::string& text, const std::string& path, const SpecOverrides& overrides) {
  refuse_xml(text, path);
  Node root = parse_yaml(text, path);
  if (root.type == Node::Type::mapping)
    for (const auto& [key, value] : in_order(overrides.values))
      apply_override(root, key, value, "--set " + key);
  Spec spec = SpecReader(path).read(root);
  check_sweep(root, spec);
  spec.text = text;
  spec.sha256 = sha256(text);
  spec.overrides = overrides.values;
  if (overrides.seed) spec.configurations.seed = *overrides.seed;
  return spec;
}

}  // namespace qerr
