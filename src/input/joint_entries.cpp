#include "input/joint_entries.hpp"

#include <fnmatch.h>

#include <algorithm>

#include "core/lists.hpp"
#include "core/text.hpp"

namespace qerr {

std::vector<std::string> joint_names(const Chain& chain) { return names_of(chain.independent); }

std::size_t find_joint(const RobotModel& robot, const Chain& chain, const std::string& name,
                       const Place& place, const std::string& path) {
  const std::vector<std::string> names = joint_names(chain);
  const auto found = std::ranges::find(names, name);
  if (found != names.end()) return found - names.begin();
  for (const Joint& joint : robot.joints) {
    if (joint.name != name) continue;
    const std::string quoted = "'" + name + "'";
    if (joint.mimic)
      throw Error(place, path, "a mimic joint has no entry of its own",
                  quoted + ", which follows '" + joint.mimic->joint + "'",
                  "give it for '" + joint.mimic->joint + "'");
    if (joint.type == JointType::fixed)
      throw Error(place, path, "the joint is fixed", quoted, did_you_mean("", names));
    throw Error(place, path, "the joint is not between base and tip", quoted, did_you_mean("", names));
  }
  if (contains(robot.links, name))
    throw Error(place, path, "this is a link, not a joint", "'" + name + "'", did_you_mean("", names));
  throw Error(place, path, "unknown joint", "'" + name + "'", did_you_mean(name, names));
}

bool off_chain(const RobotModel& robot, const Chain& chain, const std::string& name) {
  const Joint* const joint = find_named(robot.joints, name);
  return joint && joint->type != JointType::fixed && !joint->mimic && !find_named(chain.independent, name);
}

std::string list_of_names(const std::vector<std::string>& names) {
  constexpr std::size_t most = 8;
  std::string text;
  for (std::size_t i = 0; i < names.size() && i < most; ++i) text += (i ? ", " : "") + qerr::quoted(names[i]);
  return text + (names.size() > most ? " and " + std::to_string(names.size() - most) + " more" : "");
}

bool is_pattern(const std::string& key) { return key.find_first_of("*?[") != std::string::npos; }

bool fits(const std::string& pattern, const std::string& name) {
  return fnmatch(pattern.c_str(), name.c_str(), FNM_NOESCAPE) == 0;
}

namespace {

std::vector<std::size_t> fitting(const Chain& chain, const std::string& pattern) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < chain.independent.size(); ++i)
    if (fits(pattern, chain.independent[i].name)) found.push_back(i);
  return found;
}

bool is_joint(const Chain& chain, const std::string& name) {
  return find_named(chain.independent, name) != nullptr;
}

Error no_joint(const Chain& chain, const std::string& pattern, const Place& place, const std::string& path) {
  const bool open = pattern.find('[') != std::string::npos && pattern.find(']') == std::string::npos;
  return Error(place, path, "the pattern fits no joint between base and tip", qerr::quoted(pattern),
               open                                      ? "close the bracket, as in joint[1-3]"
               : pattern.find(".*") != std::string::npos ? "write * for any text, without the point"
                                                         : did_you_mean("", joint_names(chain)));
}

/// Whether a key stands for joints that move but are not part of the chain.
bool unused(const RobotModel& robot, const Chain& chain, const std::string& key) {
  if (off_chain(robot, chain, key)) return true;
  return is_pattern(key) && fitting(chain, key).empty() &&
         std::ranges::any_of(robot.joints, [&](const Joint& joint) {
           return fits(key, joint.name) && off_chain(robot, chain, joint.name);
         });
}

/// One fault for each pair of patterns, with the joints that both fit.
void refuse_overlaps(const Chain& chain, const std::vector<JointEntry>& entries, Faults& faults) {
  std::vector<std::pair<const Field*, const Field*>> pairs;
  std::vector<std::vector<std::string>> joints;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const JointEntry& e = entries[i];
    if (e.own.node || e.patterns.size() < 2) continue;
    const auto same = [&](const auto& pair) {
      return pair.first->path == e.patterns[0].path && pair.second->path == e.patterns[1].path;
    };
    const auto known = std::ranges::find_if(pairs, same);
    const auto at = static_cast<std::size_t>(known - pairs.begin());
    if (known == pairs.end()) {
      pairs.emplace_back(&e.patterns[0], &e.patterns[1]);
      joints.emplace_back();
    }
    joints[at].push_back(chain.independent[i].name);
  }
  for (std::size_t p = 0; p < pairs.size(); ++p)
    faults.guard([&] {
      throw Error(pairs[p].second->node->place, pairs[p].second->path,
                  "two patterns fit " + std::string(joints[p].size() == 1 ? "joint " : "the joints ") +
                      list_of_names(joints[p]),
                  pairs[p].first->path + " and " + pairs[p].second->path,
                  "write the joint's own name, or patterns that exclude each other");
    });
}

/// A pattern all of whose joints have entries of their own governs nothing.
void warn_of_idle_patterns(const Chain& chain, const std::vector<JointEntry>& entries,
                           std::vector<std::string>& warnings) {
  std::vector<std::pair<Field, std::vector<std::string>>> all;  // patterns, and their joints with own entries
  std::vector<const Node*> needed;
  for (std::size_t i = 0; i < entries.size(); ++i)
    for (const Field& pattern : entries[i].patterns) {
      if (!entries[i].own.node) needed.push_back(pattern.node);
      const auto same = [&](const auto& p) { return p.first.node == pattern.node; };
      auto at = std::ranges::find_if(all, same);
      if (at == all.end()) at = all.insert(at, {pattern, {}});
      at->second.push_back(chain.independent[i].name);
    }
  for (const auto& [pattern, joints] : all)
    if (!contains(needed, pattern.node))
      warnings.push_back(
          pattern.path +
          " governs nothing: the joints that it fits have entries of their own: " + list_of_names(joints));
}

}  // namespace

std::vector<std::size_t> find_joints(const RobotModel& robot, const Chain& chain, const std::string& name,
                                     const Place& place, const std::string& path) {
  if (is_joint(chain, name) || !is_pattern(name)) return {find_joint(robot, chain, name, place, path)};
  const std::vector<std::size_t> found = fitting(chain, name);
  if (found.empty()) throw no_joint(chain, name, place, path);
  return found;
}

std::vector<JointEntry> joint_entries(const Field& map, const RobotModel& robot, Spec& spec, Faults& faults) {
  const Chain& chain = spec.model.chain;
  std::vector<JointEntry> entries(chain.independent.size());
  for (const auto& entry : read_map(map)) {
    const Node::Key& key = entry.first;
    const Field& value = entry.second;
    if (unused(robot, chain, key.name)) {
      if (key.place.line == 0) {  // of an override, which would change nothing
        faults.guard([&] {
          throw Error(key.place, value.path, "governs nothing: the joint is not between base and tip",
                      qerr::quoted(key.name), did_you_mean("", joint_names(chain)));
        });
        continue;
      }
      spec.warnings.push_back(value.path + " is not used: " +
                              (is_pattern(key.name) ? "no joint that it fits is" : "the joint is not") +
                              " between base and tip");
      continue;
    }
    faults.guard([&] {
      const bool pattern = is_pattern(key.name) && !is_joint(chain, key.name);
      for (const std::size_t i : find_joints(robot, chain, key.name, key.place, value.path))
        pattern ? entries[i].patterns.push_back(value) : void(entries[i].own = value);
    });
  }
  refuse_overlaps(chain, entries, faults);
  warn_of_idle_patterns(chain, entries, spec.warnings);
  return entries;
}

void EntryFaults::add(const Fault& fault, const IndependentJoint& joint, const std::string& entry) {
  for (Shared& s : faults_)
    if (s.entry == entry && s.fault.key == fault.key && s.fault.rule == fault.rule &&
        s.fault.place.line == fault.place.line && s.fault.place.column == fault.place.column) {
      s.joints.push_back(joint.name);
      return;
    }
  faults_.push_back({fault, {joint.name}, entry});
}

void EntryFaults::raise() const {
  std::vector<Fault> all;
  for (const Shared& s : faults_) {
    all.push_back(s.fault);
    const bool named = s.fault.rule.find(qerr::quoted(s.joints.front())) != std::string::npos;
    if (!named && s.joints.size() < joints_.at(s.entry))
      all.back().rule += (s.joints.size() == 1 ? " (joint " : " (joints ") + list_of_names(s.joints) + ")";
  }
  if (!all.empty()) throw Error(all);
}

}  // namespace qerr
