#include <algorithm>
#include <filesystem>
#include <numbers>
#include <utility>

#include "core/lists.hpp"
#include "core/run_files.hpp"
#include "core/text.hpp"
#include "input/object_reader.hpp"
#include "input/read_sections.hpp"
#include "input/urdf_reader.hpp"
#include "qerr/input/first_spec.hpp"

namespace qerr {

namespace {

/// A longer link suggests a URDF in millimetres: no robot has a link of 20 m, and few have one below 20 mm.
/// Likewise a slide, of which the longest gantries have 100 m, and limits of many turns degrees.
constexpr double longest_link = 20, longest_slide = 100;  // [m]
constexpr double most_turned = 4 * 2 * std::numbers::pi;  // [rad], as of angles in a spec
constexpr double unlimited = 1e5;                         // what exporters write beyond means no limit

void warn_about_units(const Chain& chain, std::vector<std::string>& warnings) {
  double longest = chain.tip_offset.translation().norm();
  for (const ChainJoint& joint : chain.joints) longest = std::max(longest, joint.origin.translation().norm());
  if (longest > longest_link)
    warnings.push_back("a link is " + shortest(longest) + " m long: is the robot given in millimetres?");
  for (const IndependentJoint& joint : chain.independent) {
    if (!joint.limits || joint.type == JointType::continuous) continue;
    const double most = std::max(std::abs(joint.limits->lower), std::abs(joint.limits->upper));
    if (most > (joint.prismatic() ? longest_slide : most_turned) && most < unlimited)
      warnings.push_back(
          "joint '" + joint.name + "' has limits of " + text_of(*joint.limits, joint) +
          (joint.prismatic() ? ": are these millimetres?" : ": are these degrees? They are read in rad"));
  }
}

void check_version(const Object& top) {
  if (!top.has("qerr")) return;
  try {
    top.number("qerr");
  } catch (const Error&) {
    top.at("qerr").refuse("is the version of the format, and this program reads version 1",
                          "write 'qerr: 1'");
  }
}

bool is_section(const std::string& key) { return has_row(spec_format::top, key); }

/// Entries that are not indented below their section leave it empty: one mistake.
void raise_if_not_indented(const Node& root, const Faults& faults) {
  bool empty_before = false;
  for (const auto& entry : root.entries) {
    const bool known = is_section(entry.key.name);
    if (!known && empty_before) faults.raise();
    const bool empty = entry.value.type == Node::Type::null;
    if (empty || known) empty_before = empty;
  }
}

/// Gives faults about `robot.base` and `robot.tip` their place in the spec instead of the URDF.
Error placed_in_spec(const Error& e, const Field& robot) {
  std::vector<Fault> faults = e.faults();
  for (Fault& fault : faults) {
    if (!fault.key.starts_with("robot.")) continue;
    const std::string key = fault.key.substr(6);
    const std::size_t dot = key.find('.');  // of tips.NAME
    const Node* value = robot.node->find(key.substr(0, dot));
    if (value && dot != std::string::npos) value = value->find(key.substr(dot + 1));
    fault.place = value ? value->place : robot.node->place;
  }
  return Error(faults, e.trouble());
}

/// Runs the reader of a section, if the spec has it.
template <class Read>
void section(const Object& top, std::string_view key, Faults& faults, Read read) {
  if (top.has(key)) faults.guard([&] { read(top.at(key)); });
}

}  // namespace

/// A part of reading: one section, or two that are read as one.
struct SpecReader::Stage {
  std::vector<std::string> sections;
  std::vector<std::string> refers_to;  ///< further sections that it depends on, besides the robot
  void (*reset)(Spec&);                ///< to what a spec without the section has
  void (*read)(SpecReader&, const Object& top);
};

const std::vector<SpecReader::Stage>& SpecReader::stages() {
  static const std::vector<Stage> all{
      {{"encoders", "coupling"},
       {},
       [](Spec& spec) {
         spec.model.transmission = {};
         spec.encoder_figures.clear();
       },
       [](SpecReader& r, const Object& top) {
         section(top, "encoders", r.faults_,
                 [&](const Field& f) { read_encoders(f, *r.robot_, r.spec_, r.faults_); });
         section(top, "coupling", r.faults_, [&](const Field& f) { read_coupling(f, r.spec_); });
         if (!r.faults_.any()) warn_of_stated_ratios(*r.robot_, r.spec_);
       }},
      {{"coordinates", "frame"},
       {"requirements", "filters", "control", "walls"},  // which may add lengths and joints
       [](Spec& spec) {
         spec.model.coordinates.clear();
         if (!spec.model.tips) spec.model.coordinates = {Coordinate::x, Coordinate::y, Coordinate::z};
         spec.model.lengths.clear();
         spec.model.signals.clear();
         spec.model.frame = CoordinateFrame::base;
       },
       [](SpecReader& r, const Object& top) {
         if (r.joint_coordinate_) r.spec_.model.coordinates = {*r.joint_coordinate_};
         if (r.spec_.model.tips && !top.has("coordinates")) add_positions_of_tips(r.spec_.model);
         section(top, "coordinates", r.faults_, [&](const Field& f) { read_coordinates(f, r.spec_); });
         r.faults_.guard([&] {
           if (top.choice("frame") == "tip") r.spec_.model.frame = CoordinateFrame::tip;
         });
       }},
      {{"filters"},
       {},
       [](Spec& spec) { spec.filters.clear(); },
       [](SpecReader& r, const Object& top) {
         section(top, "filters", r.faults_,
                 [&](const Field& f) { read_filters(f, *r.robot_, r.spec_, r.faults_); });
       }},
      {{"estimators"},
       {"filters"},
       [](Spec& spec) { spec.estimators.clear(); },
       [](SpecReader& r, const Object& top) {
         section(top, "estimators", r.faults_,
                 [&](const Field& f) { read_estimators(f, *r.robot_, r.spec_, r.faults_); });
       }},
      {{"control", "walls"},
       {"coordinates", "frame", "filters", "requirements"},
       [](Spec& spec) {
         spec.model.control.reset();
         std::erase_if(spec.filters, [](const NamedFilter& f) { return f.controller; });
       },
       [](SpecReader& r, const Object& top) {
         if (!r.faults_.any())  // it refers to filters
           section(top, "control", r.faults_, [&](const Field& f) { read_control(f, *r.robot_, r.spec_); });
         if (!r.faults_.any())  // they refer to it
           section(top, "walls", r.faults_, [&](const Field& f) { read_walls(f, r.spec_, r.faults_); });
         add_signals_of_joints(r.spec_);
       }},
      {{"log"},
       {},
       [](Spec& spec) { spec.log = {}; },
       [](SpecReader& r, const Object& top) {
         section(top, "log", r.faults_, [&](const Field& f) { read_log_section(f, r.spec_); });
       }},
      {{"configurations"},
       {"log"},
       [](Spec& spec) {
         spec.configurations = {};
         spec.points_file.clear();
       },
       [](SpecReader& r, const Object& top) {
         r.faults_.guard([&] {
           read_configurations(top.at("configurations"), r.folder_, *r.robot_, r.spec_, r.faults_);
         });
       }},
      {{"threshold"},
       {},
       [](Spec& spec) { spec.threshold_length.reset(); },
       [](SpecReader& r, const Object& top) {
         section(top, "threshold", r.faults_, [&](const Field& f) { read_threshold(f, r.spec_); });
       }},
      {{"motion"},
       {"log"},
       [](Spec& spec) { spec.motion.reset(); },
       [](SpecReader& r, const Object& top) {
         section(top, "motion", r.faults_,
                 [&](const Field& f) { read_motion(f, r.folder_, *r.robot_, r.spec_, r.faults_); });
       }},
      {{"effects"},
       {"encoders"},
       [](Spec& spec) { spec.effects.clear(); },
       [](SpecReader& r, const Object& top) {
         section(top, "effects", r.faults_,
                 [&](const Field& f) { read_effects(f, *r.robot_, r.spec_, r.faults_); });
       }},
      {{},
       {"control", "walls", "coordinates", "frame", "filters", "requirements", "effects", "encoders"},
       [](Spec&) {},
       [](SpecReader& r, const Object& top) {
         if (!r.faults_.any() && r.spec_.model.control)  // whose section may not be among those read again
           r.faults_.guard([&] { add_loop_readings({top.self().node, "control"}, r.spec_); });
       }},
      {{"sweep"},
       {},
       [](Spec& spec) { spec.sweep.clear(); },
       [](SpecReader& r, const Object& top) {
         section(top, "sweep", r.faults_, [&](const Field& f) { read_sweep(f, r.spec_, r.faults_); });
         if (!r.spec_.sweep.empty())
           r.spec_.warnings.emplace_back(
               "sweep: is not used by this command: its figures are those of the spec's own values");
       }},
      {{"requirements"},
       {"coordinates", "frame", "filters", "control", "walls", "motion"},
       [](Spec& spec) { spec.requirements.clear(); },
       [](SpecReader& r, const Object& top) {
         r.faults_.raise();  // requirements refer to coordinates and filters
         section(top, "requirements", r.faults_,
                 [&](const Field& f) { read_requirements(f, r.spec_, r.faults_); });
       }},
      {{"design"},
       {"encoders", "coupling", "coordinates", "filters", "control", "requirements"},
       [](Spec& spec) { spec.design.reset(); },
       [](SpecReader& r, const Object& top) {
         if (!top.has("design")) return;
         r.faults_.raise();  // it refers to filters and requirements
         section(top, "design", r.faults_,
                 [&](const Field& f) { read_design(f, r.folder_, *r.robot_, r.spec_, r.faults_); });
       }},
  };
  return all;
}

SpecReader::SpecReader(const std::string& path)
    : folder_(path == "-" ? "." : std::filesystem::path(path).parent_path().string()),
      warnings_(1 + stages().size()) {
  spec_.file = path;
}

Spec SpecReader::read(const Node& root) {
  if (root.type != Node::Type::mapping)
    throw Error(root.place, "", "a spec must be a mapping", described(root), "begin with 'qerr: 1'");
  const Object top = checked_top(root);
  read_chain(top.at("robot"));
  faults_.raise();  // all further sections refer to the joints of the chain
  warnings_[0] = std::exchange(spec_.warnings, {});
  for (std::size_t i = 0; i < stages().size(); ++i) run(stages()[i], top, i);
  faults_.raise();
  return finished();
}

RobotOfSpec SpecReader::robot_of(const Node& root) {
  if (root.type != Node::Type::mapping || !root.find("robot"))
    throw Error(root.place, "robot", "the spec has no robot", "", "write robot: {urdf: arm.urdf}");
  const Chain& chain = chain_of()(root);
  return {*robot_, chain, spec_.warnings};
}

ChainOf SpecReader::chain_of() {
  return [this](const Node& root) -> const Chain& {
    if (const Node* robot = root.find("robot")) read_chain({robot, "robot"});
    faults_.raise();
    return spec_.model.chain;
  };
}

bool SpecReader::reads_again(const Stage& stage, const std::vector<std::string>& changed) {
  const auto any = [&](const std::vector<std::string>& sections) {
    return std::ranges::any_of(sections,
                               [&](const std::string& section) { return contains(changed, section); });
  };
  return any(stage.sections) || any(stage.refers_to);
}

bool SpecReader::reads_again(const std::string& section, const std::vector<std::string>& changed) {
  return std::ranges::any_of(stages(), [&](const Stage& stage) {
    return contains(stage.sections, section) && reads_again(stage, changed);
  });
}

bool SpecReader::can_change(const std::string& section) {
  return std::ranges::any_of(stages(), [&](const Stage& stage) { return contains(stage.sections, section); });
}

Spec SpecReader::reread(const Node& root, const std::vector<std::string>& changed) const {
  SpecReader again(*this);
  std::vector<Parameter> format = spec_format::top;
  for (Parameter& row : format) row.required = false;
  const Object top(Field{&root, ""}, format);
  for (std::size_t i = 0; i < stages().size(); ++i)
    if (reads_again(stages()[i], changed)) again.run(stages()[i], top, i);
  again.faults_.raise();
  return again.finished();
}

void SpecReader::run(const Stage& stage, const Object& top, std::size_t index) {
  stage.reset(spec_);
  stage.read(*this, top);
  warnings_[1 + index] = std::exchange(spec_.warnings, {});
}

Spec SpecReader::finished() const {
  Spec spec = spec_;
  for (const std::vector<std::string>& some : warnings_)
    spec.warnings.insert(spec.warnings.end(), some.begin(), some.end());
  return spec;
}

/// Unknown keys are reported together with the faults of the known sections, unless a required section is
/// missing.
Object SpecReader::checked_top(const Node& root) {
  Field field{&root, ""};
  std::vector<Parameter> format = spec_format::top;
  if (!faults_.guard([&] { Object(field, format); })) {
    raise_if_not_indented(root, faults_);
    known_ = root;
    std::erase_if(known_.entries, [](const Node::Entry& entry) { return !is_section(entry.key.name); });
    field.node = &known_;
    for (Parameter& row : format) {
      if (row.required && !root.find(row.name)) faults_.raise();
      row.required = false;
    }
  }
  Object top(field, format);
  faults_.guard([&] { check_version(top); });
  return top;
}

void SpecReader::read_chain(const Field& f) {
  faults_.guard([&] {
    if (f.node->type == Node::Type::scalar) f.refuse("must be a mapping", "write {urdf: ...}");
    const Object o(f, spec_format::robot);
    if (const int given = o.has("urdf") + o.has("joint") + o.has("dh"); given != 1)
      f.refuse(given > 1 ? "a robot has one of 'urdf', 'dh' and 'joint'"
                         : "the robot needs the key 'urdf', 'dh' for a table, or 'joint' for a single one",
               "write urdf: arm.urdf, dh: [{theta: q1, d: 0.3, a: 0, alpha: 90 deg}, ...], or joint: {name: "
               "table, type: revolute}");
    if (o.has("convention") && !o.has("dh"))
      o.at("convention").refuse("only a robot of 'dh' has a convention", "leave it out");
    std::vector<std::string> warnings;
    if (o.has("joint")) {
      robot_ = std::make_shared<const RobotModel>(read_joint(o.at("joint"), spec_.file));
      // Without a radius nothing else of the tip moves.
      if (const Joint& joint = robot_->joints.front(); robot_->joints.size() == 1)
        joint_coordinate_ = joint.type == JointType::prismatic ? Coordinate::x : Coordinate::rz;
    } else if (o.has("dh")) {
      const std::string convention = o.has("convention") ? o.choice("convention") : "";
      robot_ = std::make_shared<const RobotModel>(read_dh(o.at("dh"), convention, spec_.file, warnings));
    } else {
      const Field urdf = o.at("urdf");
      const std::string path = find_urdf(urdf, *o.text("urdf"));
      read_named_file(urdf, path, [&](const std::string& file) {
        robot_ = std::make_shared<const RobotModel>(read_urdf(file));
        name_input(file, "URDF");
      });
    }
    spec_.robot_name = o.text("name").value_or(robot_->name);
    try {
      if (o.has("tips")) {
        read_tips(o);
      } else {
        spec_.model.chain = make_chain(*robot_, o.text("base").value_or(""), o.text("tip").value_or(""));
        spec_.warnings = warnings_about(*robot_, spec_.model.chain);
      }
      spec_.warnings.insert(spec_.warnings.end(), warnings.begin(), warnings.end());
    } catch (const Error& e) {
      throw placed_in_spec(e, f);
    }
    if (o.has("tool")) spec_.model.chain.tip_offset = spec_.model.chain.tip_offset * read_pose(o.at("tool"));
    if (o.has("tracker")) spec_.model.chain.tracker = read_pose(o.at("tracker"));
    warn_about_units(spec_.model.chain, spec_.warnings);
  });
}

/// Names of tips are parts of `left.x` and `right-left.x`.
void SpecReader::read_tips(const Object& robot) {
  for (const char* key : {"tip", "tool", "tracker"})
    if (robot.has(key))
      robot.at(key).refuse("a robot of several tips has 'tips' alone",
                           "leave it out; a tool may be a fixed link of the URDF");
  std::vector<std::pair<std::string, std::string>> tips;
  for (const auto& [key, link] : read_map(robot.at("tips"))) {
    const bool word = std::ranges::all_of(key.name, [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
    });
    if (!word || key.name.empty())
      throw Error(key.place, link.path, "the name of a tip has letters, digits and '_'", quoted(key.name),
                  "such as left");
    tips.emplace_back(key.name, read_text_value(link));
  }
  if (tips.empty()) robot.at("tips").refuse("has no tip", "write tips: {left: LINK, right: LINK}");
  spec_.model.tips = std::make_shared<const std::vector<NamedTip>>(
      make_chains(*robot_, robot.text("base").value_or(""), tips));
  spec_.model.chain = spec_.model.tips->front().chain;
  // A mass matrix is that of one chain: without masses, loops need the inertia that the spec states.
  for (ChainJoint& joint : spec_.model.chain.joints) joint.load = {};
  std::vector<const Chain*> chains;
  for (std::size_t i = 0; i < tips.size(); ++i) chains.push_back(&(*spec_.model.tips)[i].chain);
  spec_.warnings = warnings_about(*robot_, chains);
  if (tips.size() > 1)
    spec_.warnings.push_back(
        "robot.tips: pictures, `tip.x`, `threshold` and `robot --at` are those of the first, '" +
        tips.front().first + "'");
}

std::string SpecReader::find_urdf(const Field& urdf, const std::string& given) const {
  try {
    return urdf_path(given, folder_);
  } catch (const Error& e) {
    Fault fault = e.faults().front();
    fault.place = urdf.node->place;
    fault.key = urdf.path;
    throw Error(fault);
  }
}

}  // namespace qerr
