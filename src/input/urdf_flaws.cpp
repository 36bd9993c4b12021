#include "input/urdf_flaws.hpp"

#include <set>

#include "core/suggest.hpp"

namespace qerr {

namespace {

// Ten times as many as a message shows. The search for similar names takes time for each of them.
constexpr std::size_t most_spoiling_flaws = 200;

}  // namespace

void FlawList::concern(const UrdfElement& element) {
  concern_document();
  const UrdfAttribute* name = element.attribute("name");
  if (element.name == "joint") part_.joints = {name ? name->value : ""};
  if (element.name == "link" && name) part_.link = name->value;
}

Flaw& FlawList::add(bool spoils, Fault fault) {
  Flaw& flaw = flaws_.emplace_back(part_);
  flaw.fault = std::move(fault);
  flaw.spoils = spoils;
  if (spoils && ++spoiling_ > most_spoiling_flaws) raise();
  return flaw;
}

void FlawList::raise() const {
  std::vector<Fault> faults;
  for (const Flaw& flaw : flaws_)
    if (flaw.spoils) faults.push_back(flaw.fault);
  if (!faults.empty()) throw Error(faults);
}

namespace {

using Names = Vocabulary::Names;

// Longer words are not compared: the longest URDF word has 17 letters.
constexpr std::size_t longest_word = 24;
// Unknown words that are compared with known ones, which bounds the time.
constexpr std::size_t most_foreign = 10000;

class VocabularyCheck {
 public:
  VocabularyCheck(const std::string& file, FlawList& flaws) : file_(file), flaws_(flaws) {}

  void visit(const UrdfElement& element, const std::string& owner) {
    const Vocabulary& row = *vocabulary(element.name);
    for (const UrdfAttribute& attribute : element.attributes) check(attribute, element, row, owner);
    std::set<std::string> seen;
    for (const UrdfElement& inner : element.children) {
      if (element.name == "robot") enter(inner);
      const bool single = Vocabulary::has(row.once, inner.name);
      if (single && !seen.insert(inner.name).second)
        flaw(inner, owner, "duplicate <" + inner.name + ">", "", "keep one of them");
      if (Vocabulary::has(row.whole, inner.name)) continue;
      if (!single && !Vocabulary::has(row.many, inner.name))
        unknown(inner, row, owner);
      else
        visit(inner, single ? owner : inner.title());
    }
    if (element.name == "robot") enter(element);
  }

 private:
  void enter(const UrdfElement& part) {
    flaws_.concern(part);
    in_link_ = part.name == "link";
  }

  /// Of a link only the inertia is read, on which no bound depends.
  template <class Located>
  void flaw(const Located& at, const std::string& owner, std::string rule, std::string found,
            std::string remedy) {
    if (in_link_)
      flaws_.warn(at, owner, std::move(rule), std::move(found), std::move(remedy));
    else
      flaws_.spoil(at, owner, std::move(rule), std::move(found), std::move(remedy));
  }

  /// The known word that `word` misspells, or "". Foreign words are stored, so that each is compared only
  /// once.
  std::string misspelt(const std::string& word, std::string_view element, const Names& known) {
    if (word.size() > longest_word || word.find(':') != std::string::npos) return {};
    std::string entry = std::string(element) + ' ' + word;
    if (foreign_.size() >= most_foreign || foreign_.contains(entry)) return {};
    std::string near = nearest(word, known);
    if (near.empty()) foreign_.insert(std::move(entry));
    return near;
  }

  void unknown(const UrdfElement& inner, const Vocabulary& row, const std::string& owner) {
    Names known = row.many;
    for (const Names* more : {&row.once, &row.whole, &row.ignored})
      known.insert(known.end(), more->begin(), more->end());
    const std::string near = misspelt(inner.name, row.element, known);
    if (near.empty() || Vocabulary::has(row.ignored, near)) return;
    flaw(inner, owner, "unknown element", "<" + inner.name + ">", "did you mean <" + near + ">?");
  }

  void check(const UrdfAttribute& attribute, const UrdfElement& element, const Vocabulary& row,
             const std::string& owner) {
    const auto& [name, value, line, column] = attribute;
    if (value.find("${") != std::string::npos || value.find("$(") != std::string::npos)
      throw Error(
          Fault{{file_, line, column},
                owner,
                "this is a xacro template, not a URDF",
                "'" + value + "'",
                "install xacro (pip install xacro, or with ROS), and it is expanded when it is read"});
    if (name == "quat_xyzw")
      flaw(attribute, owner, "a quaternion in <origin> is not supported", "'quat_xyzw'",
           "write rpy=\"ROLL PITCH YAW\" in radians");
    if (Vocabulary::has(row.attributes, name)) return;
    const std::string near = misspelt(name, element.name, row.attributes);
    if (near.empty()) return;
    std::string rule = "unknown attribute of <" + element.name + ">", found = "'" + name + "'",
                remedy = "did you mean '" + near + "'?";
    // What stands beside the word that it resembles replaces nothing: `k_velocity` beside `velocity`.
    if (element.attribute(near))
      flaws_.warn(attribute, owner, std::move(rule), std::move(found), std::move(remedy));
    else
      flaw(attribute, owner, std::move(rule), std::move(found), std::move(remedy));
  }

  const std::string& file_;
  FlawList& flaws_;
  bool in_link_ = false;
  std::set<std::string> foreign_;  ///< "ELEMENT WORD"
};

}  // namespace

const Vocabulary* vocabulary(std::string_view element) {
  static const std::vector<Vocabulary> rows = {
      {"robot",
       {"link", "joint"},
       {},
       {"transmission", "ros2_control", "gazebo"},
       {"material", "sensor"},
       {"name", "version"}},
      {"link", {}, {"inertial"}, {}, {"visual", "collision", "contact", "origin"}, {"name", "type"}},
      {"inertial", {}, {"origin", "mass", "inertia"}, {}, {}, {}},
      {"joint",
       {},
       {"origin", "parent", "child", "axis", "limit", "mimic"},
       {},
       {"dynamics", "calibration", "safety_controller", "joint_properties"},
       {"name", "type"}},
      {"origin", {}, {}, {}, {}, {"xyz", "rpy", "quat_xyzw"}},
      {"parent", {}, {}, {}, {}, {"link"}},
      {"child", {}, {}, {}, {}, {"link"}},
      {"axis", {}, {}, {}, {}, {"xyz"}},
      {"limit",
       {},
       {},
       {},
       {},
       {"lower", "upper", "effort", "velocity", "acceleration", "deceleration", "jerk"}},
      {"mimic", {}, {}, {}, {}, {"joint", "multiplier", "offset"}},
      {"mass", {}, {}, {}, {}, {"value"}},
      {"inertia", {}, {}, {}, {}, {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"}},
  };
  const auto row =
      std::find_if(rows.begin(), rows.end(), [&](const Vocabulary& v) { return v.element == element; });
  return row == rows.end() ? nullptr : &*row;
}

void check_vocabulary(const UrdfElement& root, const std::string& file, FlawList& flaws) {
  VocabularyCheck(file, flaws).visit(root, root.title());
  flaws.concern_document();
}

}  // namespace qerr
