#include "input/urdf_reader.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <set>

#include "core/text.hpp"
#include "qerr/core/parameter.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

namespace {

// Ten times as many as a message shows. The search for similar names takes time for each of them.
constexpr std::size_t most_spoiling_flaws = 200;

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
      throw Error({file_, line, column}, owner, "this is a xacro template, not a URDF", "'" + value + "'",
                  "install xacro (pip install xacro, or with ROS), and it is expanded when it is read");
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

/// Reports misspelt and duplicate elements and attributes, which a lenient reader would skip silently.
/// @throws Error (input) for values that xacro has not expanded
void check_vocabulary(const UrdfElement& root, const std::string& file, FlawList& flaws) {
  VocabularyCheck(file, flaws).visit(root, root.title());
  flaws.concern_document();
}

using Names = std::vector<std::string>;

std::vector<std::string_view> split(std::string_view text) {
  std::vector<std::string_view> words;
  constexpr std::string_view blank = " \t\r\n";
  for (std::size_t at = text.find_first_not_of(blank); at != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(blank, at), text.size());
    words.push_back(text.substr(at, end - at));
    at = text.find_first_not_of(blank, end);
  }
  return words;
}

namespace fs = std::filesystem;

constexpr int deepest_package = 5;           // of a package below a folder of ROS_PACKAGE_PATH
constexpr std::size_t most_folders = 20000;  // looked at below one of them

Error not_found(const std::string& given, const std::string& rule, const std::string& remedy) {
  return Error("", rule, quoted(given), remedy);
}

std::vector<fs::path> folders_of(const char* variable) {
  std::vector<fs::path> folders;
  const char* value = std::getenv(variable);
  const std::string list = value ? value : "";
  for (std::size_t begin = 0; begin < list.size();) {
    const std::size_t end = std::min(list.find(':', begin), list.size());
    if (end > begin) folders.emplace_back(list.substr(begin, end - begin));
    begin = end + 1;
  }
  return folders;
}

bool is_package(const fs::path& folder) {
  std::error_code ignored;
  return fs::exists(folder / "package.xml", ignored) || fs::exists(folder / "manifest.xml", ignored);
}

/// The packages of this name at or below a folder, found as rospack does: packages do not contain packages.
void search(const fs::path& folder, const std::string& package, std::vector<fs::path>& found) {
  std::error_code wrong;
  const fs::path whole = fs::weakly_canonical(folder, wrong);
  if (whole.filename() == package || fs::is_directory(folder / package, wrong))
    found.push_back(whole.filename() == package ? whole : folder / package);
  fs::recursive_directory_iterator walk(folder, fs::directory_options::skip_permission_denied, wrong);
  for (std::size_t seen = 0; !wrong && walk != fs::recursive_directory_iterator() && seen < most_folders;
       walk.increment(wrong), ++seen) {
    const fs::path& path = walk->path();
    if (!walk->is_directory(wrong)) continue;
    const bool package_here = is_package(path);
    if (package_here && path.filename() == package) found.push_back(path);
    if (package_here || walk.depth() >= deepest_package || path.filename().string().starts_with('.'))
      walk.disable_recursion_pending();
  }
}

std::string in_package(const std::string& given, const std::string& package, const std::string& path) {
  const auto ament = folders_of("AMENT_PREFIX_PATH"), ros = folders_of("ROS_PACKAGE_PATH");
  if (ament.empty() && ros.empty())
    throw not_found(given,
                    "the package cannot be looked up: AMENT_PREFIX_PATH and ROS_PACKAGE_PATH are not set",
                    "source the setup file of the ROS workspace, or give a path relative to the spec");
  std::vector<fs::path> found;
  std::error_code ignored;
  for (const fs::path& prefix : ament)
    if (fs::is_directory(prefix / "share" / package, ignored)) found.push_back(prefix / "share" / package);
  for (const fs::path& folder : ros) search(folder, package, found);
  for (const fs::path& folder : found)
    if (fs::exists(folder / path, ignored)) return (folder / path).string();
  if (found.empty())
    throw not_found(given,
                    "package '" + package + "' is in no folder of AMENT_PREFIX_PATH or ROS_PACKAGE_PATH",
                    "is it built and its workspace sourced?");
  throw not_found(given, "package '" + package + "' has no file '" + path + "'",
                  "the package is " + found.front().string());
}

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
  const auto row = std::ranges::find_if(rows, [&](const Vocabulary& v) { return v.element == element; });
  return row == rows.end() ? nullptr : &*row;
}

void UrdfReader::read(const UrdfElement& root) {
  check_vocabulary(root, file_, flaws_);
  read_robot(root);
  for (const UrdfElement& child : root.children) {
    flaws_.concern(child);
    if (child.name == "link") read_link(child);
    if (child.name == "joint") read_joint(child);
  }
  if (model.links.empty()) {
    flaws_.raise();
    refuse(root, "a robot must have at least one link", "",
           root.attribute("xmlns:xacro") ? "is this a file of xacro macros? Expand the file that calls them"
                                         : "");
  }
  check_tree(root);
  check_mimics();
  read_ratios(root);
  model.flaws = flaws_.take();
}

void UrdfReader::refuse(const UrdfElement& root, std::string rule, std::string found, std::string remedy) {
  throw Error({file_, root.line, root.column}, root.title(), std::move(rule), std::move(found),
              std::move(remedy));
}

/// Exactly N numbers of an attribute; empty if it is absent or, after reporting a fault, invalid.
template <std::size_t N>
std::optional<std::array<double, N>> UrdfReader::numbers(const UrdfElement& element, const char* name,
                                                         const std::string& key) {
  const UrdfAttribute* attribute = element.attribute(name);
  if (!attribute) return {};
  const auto words = split(attribute->value);
  // An axis is a direction, of any length.
  const bool is_length = element.name == "origin" && name == std::string_view("xyz");
  const double most = element.name == "axis"
                          ? HUGE_VAL
                          : physical_range(is_length ? dimension::length : dimension::none).largest;
  bool too_large = false;
  std::array<double, N> values{};
  bool good = words.size() == N;
  for (std::size_t i = 0; good && i < N; ++i) {
    const auto value = parse_number(words[i]);
    good = value.has_value();
    too_large = too_large || std::abs(value.value_or(0)) > most;
    values[i] = value.value_or(0);
  }
  if (good && !too_large) return values;
  if (good) {
    spoil(*attribute, key, "'" + std::string(name) + "' of <" + element.name + "> is out of range",
          quoted(attribute->value), "give values of at most " + shortest(most));
    return {};
  }
  const bool comma = attribute->value.find(',') != std::string::npos;
  spoil(*attribute, key,
        "'" + std::string(name) + "' of <" + element.name + "> must be " +
            (N == 1 ? "a finite number" : counted(N, "finite number")),
        quoted(attribute->value), comma ? "use a decimal point, and blanks between numbers" : "");
  return {};
}

std::optional<double> UrdfReader::number(const UrdfElement& element, const char* name,
                                         const std::string& key) {
  const auto one = numbers<1>(element, name, key);
  return one ? std::optional((*one)[0]) : std::nullopt;
}

template std::optional<std::array<double, 3>> UrdfReader::numbers<3>(const UrdfElement&, const char*,
                                                                     const std::string&);

/// The name of a link or joint; "" after reporting a flaw.
std::string UrdfReader::name_of(const UrdfElement& element) {
  const UrdfAttribute* name = element.attribute("name");
  if (!name)
    spoil(element, element.name, "a " + element.name + " must have a name", "", "");
  else if (name->value.empty())
    spoil(*name, element.name, "the name of a " + element.name + " must not be empty", "", "");
  else if (escaped(name->value, std::string::npos) != name->value)
    spoil(*name, element.name, "a name must not contain control or invisible characters", quoted(name->value),
          "type it anew");
  return name ? name->value : "";
}

/// A required attribute of a required child; "" after reporting a fault.
std::string UrdfReader::text_of(const UrdfElement* element, const char* tag, const char* attribute,
                                const UrdfElement& owner) {
  const std::string wanted = "<" + std::string(tag) + " " + attribute + "=\"...\"/>";
  const UrdfAttribute* given = element ? element->attribute(attribute) : nullptr;
  if (!element)
    spoil(owner, owner.title(), "a joint must have a <" + std::string(tag) + ">", "", "add " + wanted);
  else if (!given)
    spoil(*element, owner.title(), "<" + std::string(tag) + "> must have '" + attribute + "'", "",
          "write " + wanted);
  else if (given->value.empty())
    spoil(*given, owner.title(), "'" + std::string(attribute) + "' of <" + tag + "> must not be empty", "",
          "");
  return given ? given->value : "";
}

void UrdfReader::read_robot(const UrdfElement& root) {
  model.file = file_;
  // URDFs of real robots have been published without a name, to which nothing refers.
  const UrdfAttribute* name = root.attribute("name");
  if (!name || name->value.empty())
    flaws_.warn(root, "robot", name ? "the name is empty" : "a robot must have a name");
  model.name = name ? name->value : "";
  const UrdfAttribute* version = root.attribute("version");
  static const Names versions = {"1", "1.0", "1.1", "1.2"};
  if (version && !contains(versions, version->value))
    refuse(root, "unknown version of URDF", quoted(version->value), "known: 1.0, 1.1, 1.2");
}

void UrdfReader::read_link(const UrdfElement& element) {
  const std::string name = name_of(element);
  if (name.empty()) return;
  if (!link_index_.emplace(name, model.links.size()).second) {
    spoil(*element.attribute("name"), element.title(), "duplicate name of a link", "", "rename one of them");
    return;
  }
  model.links.push_back(name);
  Inertia& inertia = model.inertias.emplace_back();
  const UrdfElement* inertial = element.child("inertial");
  if (!inertial) return;
  const std::string key = element.title();
  Eigen::Vector3d rpy = Eigen::Vector3d::Zero();
  read_origin(*inertial, key, inertia.center, rpy);
  if (const UrdfElement* mass = inertial->child("mass")) {
    const auto value = number(*mass, "value", key);
    if (value && *value < 0) spoil(*mass, key, "a mass must not be negative", quoted(shortest(*value)), "");
    inertia.mass = value.value_or(0);
  }
  const UrdfElement* moments = inertial->child("inertia");
  if (!moments) return;
  const auto moment = [&](const char* entry) { return number(*moments, entry, key).value_or(0); };
  Eigen::Matrix3d m;
  m(0, 0) = moment("ixx");
  m(0, 1) = m(1, 0) = moment("ixy");
  m(0, 2) = m(2, 0) = moment("ixz");
  m(1, 1) = moment("iyy");
  m(1, 2) = m(2, 1) = moment("iyz");
  m(2, 2) = moment("izz");
  const Eigen::Matrix3d rotation = (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
                                       .toRotationMatrix();
  inertia.about_center = rotation * m * rotation.transpose();
}

void UrdfReader::read_origin(const UrdfElement& owner, const std::string& key, Eigen::Vector3d& xyz,
                             Eigen::Vector3d& rpy) {
  const UrdfElement* origin = owner.child("origin");
  if (!origin) return;
  if (const auto values = numbers<3>(*origin, "xyz", key)) xyz = Eigen::Vector3d(values->data());
  if (const auto values = numbers<3>(*origin, "rpy", key)) rpy = Eigen::Vector3d(values->data());
  if (rpy.cwiseAbs().maxCoeff() > 2 * std::numbers::pi + 1e-3)
    flaws_.warn(*origin, key, "an angle of rpy exceeds a full turn; rpy is in radians: are these degrees?");
}

std::string urdf_path(const std::string& given, const std::string& folder) {
  const std::size_t colon = given.find("://");
  if (colon == std::string::npos) return (fs::path(folder) / given).string();
  const std::string scheme = given.substr(0, colon), rest = given.substr(colon + 3);
  if (scheme == "file") return rest;
  const std::size_t slash = rest.find('/');
  if (scheme == "package" && slash != std::string::npos && slash > 0 && slash + 1 < rest.size())
    return in_package(given, rest.substr(0, slash), rest.substr(slash + 1));
  throw not_found(given, "robot.urdf must be a path, package://PACKAGE/PATH or file:///PATH", "");
}

}  // namespace qerr
