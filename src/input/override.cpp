#include "input/override.hpp"

#include <algorithm>
#include <charconv>
#include <optional>

#include "core/suggest.hpp"
#include "core/text.hpp"
#include "input/encoder_keys.hpp"
#include "input/joint_entries.hpp"
#include "input/spec_format.hpp"
#include "qerr/encoder/encoder_kinds.hpp"

namespace qerr {

namespace {

/// The first key of a path, and what follows it.
struct PathStep {
  std::string key, rest;
};

/// A leading list index, `3` or `[3]`.
std::optional<std::pair<std::size_t, std::string>> leading_index(const std::string& path) {
  const bool bracket = path.starts_with('[');
  const char* const begin = path.data() + (bracket ? 1 : 0);
  const char* const end = path.data() + path.size();
  std::size_t index = 0;
  auto [after, failure] = std::from_chars(begin, end, index);
  if (failure != std::errc{} || (bracket && (after == end || *after++ != ']'))) return std::nullopt;
  if (after != end && *after != '.' && *after != '[') return std::nullopt;
  if (after != end && *after == '.') ++after;
  return std::pair(index, std::string(after, end));
}

bool is_encoder_key(const std::string& word) {
  const std::vector<std::string> keys = encoder_keys();
  return std::find(keys.begin(), keys.end(), word) != keys.end();
}

/// One change of a tree.
class Override {
 public:
  Override(Node& root, std::string path, const Node& value)
      : root_(root), path_(std::move(path)), value_(value), place_(value.place) {}

  void apply() {
    Node* node = &root_;
    std::string passed, rest = path_;
    do {
      if (node->type == Node::Type::sequence) {
        node = &item(*node, passed, rest);
        continue;
      }
      if (node->type == Node::Type::null) node->type = Node::Type::mapping;
      if (node->type != Node::Type::mapping)
        refuse("'" + passed + "' is a single value and has no keys", described(*node),
               "shorten the path to " + passed);
      node = &child(*node, passed, rest);
    } while (!rest.empty());
    *node = value_;
  }

 private:
  [[noreturn]] void refuse(const std::string& rule, const std::string& found,
                           const std::string& remedy) const {
    throw Error({place_, path_, rule, found, remedy});
  }

  Node& item(Node& list, std::string& passed, std::string& rest) const {
    const auto index = leading_index(rest);
    const std::string range =
        list.items.empty() ? "the list is empty"
                           : "give " + passed + "[0]" +
                                 (list.items.size() == 1
                                      ? ""
                                      : " to " + passed + '[' + std::to_string(list.items.size() - 1) + ']');
    if (!index || index->first >= list.items.size())
      refuse("'" + passed + "' is a list of " + counted(list.items.size(), "item") + ", counted from 0",
             qerr::quoted(rest), range);
    passed += '[' + std::to_string(index->first) + ']';
    rest = index->second;
    return list.items[index->first];
  }

  Node& child(Node& map, std::string& passed, std::string& rest) const {
    Node::Entry* found = longest_match(map, rest);
    const PathStep step = found ? split_at(rest, found->key.name.size()) : new_key(passed, rest);
    if (step.key.empty())
      refuse("a key of the path is empty", qerr::quoted(path_),
             "name a key, such as filters.velocity.lowpass.cutoff");
    if (!found) found = &added(map, passed, step);
    if (passed.starts_with("encoders.") && step.rest.empty()) exclude_other_keys(map, step.key);
    passed += (passed.empty() ? "" : ".") + step.key;
    rest = step.rest;
    return *map.find(step.key);
  }

  static Node::Entry* longest_match(Node& map, const std::string& path) {
    Node::Entry* found = nullptr;
    for (Node::Entry& entry : map.entries) {
      const std::string& name = entry.key.name;
      const bool list = entry.value.type == Node::Type::sequence;
      const bool matches =
          path == name || path.starts_with(name + '.') || (list && path.starts_with(name + '['));
      if (matches && (!found || name.size() >= found->key.name.size())) found = &entry;
    }
    return found;
  }

  static PathStep split_at(const std::string& path, std::size_t length) {
    const bool dot = length < path.size() && path[length] == '.';
    return {path.substr(0, length), path.substr(std::min(path.size(), length + (dot ? 1 : 0)))};
  }

  /// A key that the mapping lacks. A joint's name may contain dots: it ends before a key of an encoder, or at
  /// the end of the path.
  PathStep new_key(const std::string& passed, const std::string& rest) const {
    if (passed == "encoders") {
      const std::size_t last = rest.rfind('.');
      if (last != std::string::npos && is_encoder_key(rest.substr(last + 1))) return split_at(rest, last);
      if (value_.type == Node::Type::mapping) return {rest, ""};
    }
    return split_at(rest, std::min(rest.find('.'), rest.size()));
  }

  Node::Entry& added(Node& map, const std::string& passed, const PathStep& step) const {
    Node node{Node::Type::null, place_, {}, false, {}, {}};
    const bool by_joint = passed == "encoders" || passed == "configurations.limits";
    if (passed.empty()) refuse_new_section(step);
    if (by_joint && !step.rest.empty() && !is_pattern(step.key))
      if (const Node* pattern = of_pattern(map, passed, step.key)) node = *pattern;
    if (passed == "filters" && !step.rest.empty()) refuse_new_filter(map, step.key);
    map.entries.push_back({{step.key, place_}, std::move(node)});
    return map.entries.back();
  }

  /// `requirements.0.at_most` or `requirements[0].at_most` in a spec without requirements,
  /// `encoders/a2/bits`.
  void refuse_new_section(const PathStep& step) const {
    const std::size_t other = step.key.find_first_of("/:\\");
    if (other != std::string::npos)
      refuse("unknown key", qerr::quoted(step.key),
             "separate the keys of a path by points, as in encoders.elbow.bits");
    for (const Parameter& row : spec_format::top())
      if (row.kind == Kind::objects &&
          (step.key.starts_with(std::string(row.name) + '[') || (step.key == row.name && !step.rest.empty())))
        refuse("the spec has no " + std::string(row.name), qerr::quoted(path_),
               "set the whole list: --set '" + std::string(row.name) + "=[{...}]'");
  }

  /// The entry of the pattern that fits a joint; null if there is none.
  const Node* of_pattern(const Node& map, const std::string& passed, const std::string& joint) const {
    const Node::Entry* found = nullptr;
    for (const Node::Entry& entry : map.entries) {
      if (!is_pattern(entry.key.name) || !fits(entry.key.name, joint)) continue;
      if (found)
        refuse("two patterns fit joint " + qerr::quoted(joint),
               passed + '.' + found->key.name + " and " + passed + '.' + entry.key.name,
               "set the whole entry: --set '" + passed + '.' + joint + "={...}'");
      found = &entry;
    }
    return found ? &found->value : nullptr;
  }

  [[noreturn]] void refuse_new_filter(const Node& map, const std::string& name) const {
    std::vector<std::string> known;
    for (const Node::Entry& entry : map.entries) known.push_back(entry.key.name);
    refuse("the spec has no filter of this name", qerr::quoted(name),
           known.empty() ? "add the filter to the spec" : did_you_mean(name, known));
  }

  /// Removes the keys of other kinds that the kind of this key does not have.
  static void exclude_other_keys(Node& entry, const std::string& key) {
    const auto& kinds = encoder_kinds();
    const auto kind = std::find_if(kinds.begin(), kinds.end(), [&](const auto& k) { return k.name == key; });
    if (kind == kinds.end()) return;
    const std::vector<Parameter> own = encoder_parameters(*kind);
    std::erase_if(entry.entries, [&](const Node::Entry& other) {
      return is_encoder_key(other.key.name) &&
             std::none_of(own.begin(), own.end(), [&](const auto& p) { return p.name == other.key.name; });
    });
  }

  Node& root_;
  std::string path_;
  const Node& value_;
  Place place_;
};

/// Values of the command line have no line and column.
void set_place(Node& node, const Place& place) {
  node.place = place;
  for (Node& item : node.items) set_place(item, place);
  for (Node::Entry& entry : node.entries) {
    entry.key.place = place;
    set_place(entry.value, place);
  }
}

Node value_of(const std::string& text, const std::string& path, const Place& place) {
  try {
    Node value = parse_yaml(text.empty() ? "''" : text, place.file);
    set_place(value, place);
    return value;
  } catch (const Error& e) {
    Fault fault = e.faults().front();
    throw Error(
        {place, path, fault.rule, fault.found.empty() ? qerr::quoted(text) : fault.found, fault.remedy});
  }
}

}  // namespace

namespace {

/// The part of a path below a section by joints; empty for other paths.
std::optional<std::string> below_joints(const std::string& path) {
  for (const std::string section : {"encoders.", "configurations.limits."})
    if (path.starts_with(section)) return path.substr(section.size());
  return std::nullopt;
}

/// Whether the path is that of a pattern's entry; `a1[0]` is an item of a list.
bool changes_pattern(const SpecChange& change) {
  const auto rest = below_joints(change.first);
  if (!rest) return false;
  const std::size_t special = rest->find_first_of("*?[");
  return special != std::string::npos && !((*rest)[special] == '[' && leading_index(rest->substr(special)));
}

bool changes_section(const SpecChange& change) {
  const std::string& path = change.first;
  return path == "encoders" || path == "configurations" || path == "configurations.limits";
}

}  // namespace

std::vector<SpecChange> in_order(std::vector<SpecChange> changes) {
  auto begin = changes.begin();
  while (begin != changes.end()) {
    const auto end = std::find_if(begin, changes.end(), changes_section);
    std::stable_partition(begin, end, changes_pattern);
    begin = end == changes.end() ? end : end + 1;
  }
  return changes;
}

void apply_override(Node& root, const SpecChange& change) {
  Override(root, change.first, change.second).apply();
}

SpecChange spec_change(const std::string& path, const std::string& text, const std::string& origin) {
  const Place place{origin, 0, 0};
  if (path.find_first_not_of(' ') == std::string::npos)
    throw Error({place, path, "a key is missing", "", "such as filters.velocity.lowpass.cutoff"});
  const std::size_t first = path.find_first_not_of(' '), last = path.find_last_not_of(' ');
  const std::string trimmed = path.substr(first, last + 1 - first);
  if (trimmed.ends_with('.'))
    throw Error({place, path, "the path ends with a point", "'" + trimmed + "'", "name the key after it"});
  return {trimmed, value_of(text, trimmed, place)};
}

std::vector<SpecChange> spec_changes(const std::vector<std::pair<std::string, std::string>>& set) {
  std::vector<SpecChange> changes;
  for (const auto& [key, value] : set) changes.push_back(spec_change(key, value, "--set " + key));
  return changes;
}

}  // namespace qerr
