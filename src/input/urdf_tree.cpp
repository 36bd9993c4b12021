#include <algorithm>

#include "core/suggest.hpp"
#include "core/text.hpp"
#include "input/urdf_reader.hpp"

namespace qerr {

namespace {

using Names = std::vector<std::string>;

/// At most six names, for a message.
std::string listed(const Names& names, const char* between = ", ") {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i == 6) return text + between + "...";
    text += (i ? between : "") + qerr::quoted(names[i]);
  }
  return text;
}

/// A suggestion for a misspelt name; none for robots with thousands of names, since it compares all of them.
std::string suggestion(const std::string& word, const Names& known) {
  return known.size() > 5000 ? "" : did_you_mean(word, known);
}

}  // namespace

/// Excludes a joint from the tree if it does not join two links of the robot, or if its child has a parent
/// already.
void UrdfReader::check_ends(WrittenJoint& w) {
  const Joint& joint = w.joint;
  const std::string key = w.element->title();
  const std::size_t index = static_cast<std::size_t>(&w - written.data());
  for (const auto& [tag, link] : {std::pair("parent", &joint.parent), std::pair("child", &joint.child)}) {
    if (link_index_.contains(*link)) continue;
    w.in_tree = false;
    if (link->empty()) continue;  // reported where it was read
    Flaw& flaw = spoil(*w.element->child(tag)->attribute("link"), key,
                       "the " + std::string(tag) + " is not a link of this robot", qerr::quoted(*link),
                       suggestion(*link, model.links));
    if (tag == std::string_view("parent") && joint.type != JointType::fixed)
      flaw.below_missing_joint = joint.child;
  }
  if (joint.child.empty()) return;
  const UrdfAttribute& child = *w.element->child("child")->attribute("link");
  if (joint.child == joint.parent) {
    spoil(child, key, "parent and child must be different links", qerr::quoted(joint.child) + " for both",
          "");
    w.in_tree = false;
  }
  if (!w.in_tree) return;
  const auto [first, fresh] = parent_joint_.emplace(joint.child, index);
  if (fresh) return;
  w.in_tree = false;
  const std::string other = written[first->second].joint.name;
  spoil(child, key,
        "a link must have one parent; " + qerr::quoted(joint.child) + " is already the child of joint " +
            qerr::quoted(other),
        "", "")
      .joints.push_back(other);
}

/// Makes the graph a forest. If every link has at most one parent, only cycles remain to be cut.
void UrdfReader::check_tree(const UrdfElement& root) {
  for (WrittenJoint& w : written) {
    flaws_.concern_joint(w.joint.name);
    check_ends(w);
  }
  flaws_.concern_document();
  std::unordered_map<std::string, std::size_t> visited;  // link -> the first walk that visited it
  for (std::size_t walk = 0; walk < model.links.size(); ++walk) {
    std::string link = model.links[walk];
    Names path;
    for (auto up = parent_joint_.find(link); visited.emplace(link, walk).second && up != parent_joint_.end();
         up = parent_joint_.find(link)) {
      path.push_back(link);
      link = written[up->second].joint.parent;
    }
    const auto repeat = std::find(path.begin(), path.end(), link);
    if (repeat == path.end()) continue;
    WrittenJoint& joint = written[parent_joint_.at(link)];
    Names loop(repeat, path.end());
    loop.push_back(link);
    Flaw& flaw = spoil(*joint.element, joint.element->title(), "the links form a loop; a URDF must be a tree",
                       listed(loop, " under "), "");
    for (const std::string& each : loop) flaw.joints.push_back(written[parent_joint_.at(each)].joint.name);
    joint.in_tree = false;
    parent_joint_.erase(link);
  }
  // Where a joint is excluded, further roots are its consequence.
  if (std::all_of(written.begin(), written.end(), [](const WrittenJoint& w) { return w.in_tree; }))
    check_roots(root);
}

void UrdfReader::check_roots(const UrdfElement& root) {
  Names roots;
  for (const std::string& link : model.links)
    if (!parent_joint_.contains(link)) roots.push_back(link);
  if (roots.size() < 2) return;
  for (const UrdfElement& child : root.children) {
    const UrdfAttribute* name = child.attribute("name");  // null in a link that is reported for that
    if (child.name != "link" || !name || name->value != roots[1]) continue;
    spoil(child, child.title(), "a robot must have one root link",
          counted(roots.size(), "root") + ": " + listed(roots), "join them by a joint, or name robot.base");
  }
}

/// Reports a mimic that cannot be followed: the joint then has a coordinate of its own, and is spoilt.
void UrdfReader::drop_mimic(WrittenJoint& w, std::string rule, std::string found, std::string remedy) {
  const UrdfElement& mimic = *w.element->child("mimic");
  const UrdfAttribute* target = mimic.attribute("joint");
  flaws_.concern_joint(w.joint.name);
  if (target)
    spoil(*target, w.element->title(), std::move(rule), std::move(found), std::move(remedy));
  else
    spoil(mimic, w.element->title(), std::move(rule), std::move(found), std::move(remedy));
  w.joint.mimic.reset();
}

void UrdfReader::check_mimics() {
  Names names;
  for (const WrittenJoint& w : written) names.push_back(w.joint.name);
  for (WrittenJoint& w : written) {
    if (!w.joint.mimic) continue;
    const std::string& target = w.joint.mimic->joint;
    const auto found = joint_index_.find(target);
    if (target.empty()) {
      w.joint.mimic.reset();  // reported where it was read
    } else if (found == joint_index_.end()) {
      drop_mimic(w, "unknown joint to mimic", qerr::quoted(target), suggestion(target, names));
    } else if (const WrittenJoint& master = written[found->second]; !has_one_coordinate(master.joint.type)) {
      drop_mimic(w, "the joint to mimic must be revolute, continuous or prismatic",
                 qerr::quoted(target) + ", which is " + std::string(joint_type_name(master.joint.type)), "");
    } else if (!master.in_tree) {
      drop_mimic(w, "the joint to mimic is not part of the tree", qerr::quoted(target), "");
    }
  }
  check_mimic_loops();
  flaws_.concern_document();
}

void UrdfReader::check_mimic_loops() {
  std::vector<std::size_t> visited(written.size(), written.size());  // the first walk that visited a joint
  const auto next = [&](std::size_t joint) { return joint_index_.at(written[joint].joint.mimic->joint); };
  for (std::size_t walk = 0; walk < written.size(); ++walk) {
    std::size_t at = walk;
    for (; written[at].joint.mimic && visited[at] == written.size(); at = next(at)) visited[at] = walk;
    if (!written[at].joint.mimic || visited[at] != walk) continue;
    Names loop{written[at].joint.name};
    for (std::size_t other = at; loop.size() < 2 || other != at;)
      loop.push_back(written[other = next(other)].joint.name);
    drop_mimic(written[at],
               loop.size() == 2 ? "a joint cannot mimic itself" : "joints mimic each other in a loop",
               listed(loop, " mimics "), "");
  }
}

}  // namespace qerr
