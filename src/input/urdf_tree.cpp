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

void UrdfReader::check_ends(const WrittenJoint& w) {
  const Joint& joint = w.joint;
  const std::string key = w.element->title();
  for (const auto& [tag, link] : {std::pair("parent", &joint.parent), std::pair("child", &joint.child)}) {
    if (link->empty() || link_index_.contains(*link)) continue;
    fault(*w.element->child(tag)->attribute("link"), key,
          "the " + std::string(tag) + " is not a link of this robot", qerr::quoted(*link),
          suggestion(*link, model.links));
  }
  if (joint.child.empty()) return;
  const UrdfAttribute& child = *w.element->child("child")->attribute("link");
  if (joint.child == joint.parent)
    fault(child, key, "parent and child must be different links", qerr::quoted(joint.child) + " for both",
          "");
  const auto [first, fresh] =
      parent_joint_.emplace(joint.child, static_cast<std::size_t>(&w - written.data()));
  if (!fresh)
    fault(child, key,
          "a link must have one parent; " + qerr::quoted(joint.child) + " is already the child of joint " +
              qerr::quoted(written[first->second].joint.name),
          "", "");
}

/// If every link has at most one parent, the graph is a tree if and only if there is one root and no cycle.
void UrdfReader::check_tree(const UrdfElement& root) {
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
    const WrittenJoint& joint = written[parent_joint_.at(link)];
    Names loop(repeat, path.end());
    loop.push_back(link);
    fault(*joint.element, joint.element->title(), "the links form a loop; a URDF must be a tree",
          listed(loop, " under "), "");
  }
  faults_.raise();
  Names roots;
  for (const std::string& link : model.links)
    if (!parent_joint_.contains(link)) roots.push_back(link);
  if (roots.size() < 2) return;
  for (const UrdfElement& child : root.children) {
    if (child.name != "link" || child.attribute("name")->value != roots[1]) continue;
    fault(child, child.title(), "a robot must have one root link",
          counted(roots.size(), "root") + ": " + listed(roots), "join them by a joint");
  }
}

void UrdfReader::check_mimics() {
  Names names;
  for (const WrittenJoint& w : written) names.push_back(w.joint.name);
  for (const WrittenJoint& w : written) {
    if (!w.joint.mimic) continue;
    const std::string& target = w.joint.mimic->joint;
    const UrdfAttribute& at = *w.element->child("mimic")->attribute("joint");
    const auto found = joint_index_.find(target);
    if (found == joint_index_.end())
      fault(at, w.element->title(), "unknown joint to mimic", qerr::quoted(target),
            suggestion(target, names));
    else if (!has_one_coordinate(written[found->second].joint.type))
      fault(at, w.element->title(), "the joint to mimic must be revolute, continuous or prismatic",
            qerr::quoted(target) + ", which is " +
                std::string(joint_type_name(written[found->second].joint.type)),
            "");
  }
  faults_.raise();
  std::vector<std::size_t> visited(written.size(), written.size());  // the first walk that visited a joint
  for (std::size_t walk = 0; walk < written.size(); ++walk) {
    std::size_t at = walk;
    for (; written[at].joint.mimic && visited[at] == written.size();
         at = joint_index_.at(written[at].joint.mimic->joint))
      visited[at] = walk;
    if (!written[at].joint.mimic || visited[at] != walk) continue;
    Names loop{names[at]};
    for (std::size_t next = at; loop.size() < 2 || next != at;) {
      next = joint_index_.at(written[next].joint.mimic->joint);
      loop.push_back(names[next]);
    }
    fault(*written[at].element->child("mimic"), written[at].element->title(),
          loop.size() == 2 ? "a joint cannot mimic itself" : "joints mimic each other in a loop",
          listed(loop, " mimics "), "");
  }
}

}  // namespace qerr
