#include <algorithm>
#include <charconv>
#include <optional>
#include <span>

#include "core/lists.hpp"
#include "core/text.hpp"
#include "input/joint_entries.hpp"
#include "input/read_sections.hpp"
#include "qerr/encoder/encoder.hpp"

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

/// Removes the keys of other kinds that the kind of this key does not have.
void exclude_other_keys(Node& entry, const std::string& key) {
  const EncoderKind* const kind = find_named(encoder_kinds(), key);
  if (!kind) return;
  const std::vector<Parameter> own = encoder_parameters(*kind);
  std::erase_if(entry.entries, [&](const Node::Entry& other) {
    return is_encoder_key(other.key.name) && !find_named(own, other.key.name);
  });
}

class Override {
 public:
  explicit Override(const SpecChange& change)
      : path_(change.first), value_(change.second), place_(change.second.place) {}

  /// @param node    where the change begins
  /// @param passed  the path of that node
  /// @param rest    the path below it; "" replaces the node
  void apply(Node* node, std::string passed, std::string rest) const {
    while (!rest.empty()) {
      if (node->type == Node::Type::sequence) {
        node = &item(*node, passed, rest);
        continue;
      }
      if (node->type == Node::Type::null) node->type = Node::Type::mapping;
      if (node->type != Node::Type::mapping)
        refuse("'" + passed + "' is a single value and has no keys", described(*node),
               "shorten the path to " + passed);
      node = &child(*node, passed, rest);
    }
    *node = value_;
  }

  [[noreturn]] void refuse(const std::string& rule, const std::string& found,
                           const std::string& remedy) const {
    throw Error(place_, path_, rule, found, remedy);
  }

 private:
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
    const PathStep step =
        split_at(rest, found ? found->key.name.size() : std::min(rest.find('.'), rest.size()));
    if (step.key.empty())
      refuse("a key of the path is empty", qerr::quoted(path_),
             "name a key, such as filters.velocity.lowpass.cutoff");
    if (!found) found = &added(map, passed, step);
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

  Node::Entry& added(Node& map, const std::string& passed, const PathStep& step) const {
    if (passed.empty()) refuse_new_section(step);
    if (passed == "filters" && !step.rest.empty()) refuse_new_filter(map, step.key);
    map.entries.push_back({{step.key, place_}, {Node::Type::null, place_, {}, false, {}, {}}});
    return map.entries.back();
  }

  /// `requirements.0.at_most` or `requirements[0].at_most` in a spec without requirements,
  /// `encoders/a2/bits`.
  void refuse_new_section(const PathStep& step) const {
    const std::size_t other = step.key.find_first_of("/:\\");
    if (other != std::string::npos)
      refuse("unknown key", qerr::quoted(step.key),
             "separate the keys of a path by points, as in encoders.elbow.bits");
    for (const Parameter& row : spec_format::top)
      if (row.kind == Kind::objects &&
          (step.key.starts_with(std::string(row.name) + '[') || (step.key == row.name && !step.rest.empty())))
        refuse("the spec has no " + std::string(row.name), qerr::quoted(path_),
               "set the whole list: --set '" + std::string(row.name) + "=[{...}]'");
  }

  [[noreturn]] void refuse_new_filter(const Node& map, const std::string& name) const {
    std::vector<std::string> known;
    for (const Node::Entry& entry : map.entries) known.push_back(entry.key.name);
    refuse("the spec has no filter of this name", qerr::quoted(name),
           known.empty() ? "add the filter to the spec" : did_you_mean(name, known));
  }

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
    throw Error(place, path, fault.rule, fault.found.empty() ? qerr::quoted(text) : fault.found,
                fault.remedy);
  }
}

struct JointChange {
  std::string map;    ///< path of the mapping
  std::string joint;  ///< a name or a pattern
  std::string rest;   ///< path within the entry; "" for the whole entry
};

/// Whether a text may end a joint's name at this place: before a key or an index.
bool ends_name(const std::string& path, std::size_t at) {
  return at == path.size() || path[at] == '.' || (path[at] == '[' && leading_index(path.substr(at)));
}

/// Where the joint's name ends: it may contain points, and so may a pattern. The longest text that is an
/// entry or stands for a joint; else what stands before the last key, if that is a key of encoders.
std::size_t name_length(const std::string& path, const Node* map, const Chain& chain, bool whole_entry) {
  std::size_t longest = 0;
  for (std::size_t at = 1; at <= path.size(); ++at) {
    if (!ends_name(path, at)) continue;
    const std::string name = path.substr(0, at);
    const bool entry = map && map->find(name);
    if (entry || std::ranges::any_of(chain.independent, [&](const auto& joint) {
          return joint.name == name || fits(name, joint.name);
        }))
      longest = at;
  }
  if (longest > 0) return longest;
  const std::size_t last = path.rfind('.');
  if (last != std::string::npos && is_encoder_key(path.substr(last + 1))) return last;
  return whole_entry ? path.size() : std::min(path.find('.'), path.size());
}

Node* find_path(Node& root, const std::string& path) {
  const std::size_t point = std::min(path.find('.'), path.size());
  Node* const child = root.find(path.substr(0, point));
  return !child || point == path.size() ? child : find_path(*child, path.substr(point + 1));
}

/// A key with items of lists as `.3`, which may be written `[3]`.
std::string with_dots(const std::string& key) {
  std::string out;
  for (const char c : key)
    if (c == '[')
      out += '.';
    else if (c != ']')
      out += c;
  return out;
}

/// The mappings by joints, whose keys may be patterns.
constexpr const char* joint_maps[] = {"encoders", "configurations.limits", "control.joints",
                                      "design.encoders"};

/// The mapping by joints within which a path lies; "" for other paths.
std::string joint_map_of(const std::string& path) {
  for (const std::string map : joint_maps)
    if (path.starts_with(map + '.')) return map;
  return "";
}

/// The change of the entries that govern the joints of a name or a pattern.
class JointOverride {
 public:
  JointOverride(Node& root, const SpecChange& change, const Chain& chain)
      : override_(change), value_(change.second), place_(change.second.place), chain_(chain) {
    path_.map = joint_map_of(change.first);
    map_ = find_path(root, path_.map);
    if (!map_ || map_->type == Node::Type::null) {
      override_.apply(&root, "", path_.map + ".x");  // begins the mapping
      map_ = find_path(root, path_.map);
      map_->entries.clear();
    }
    const std::string below = change.first.substr(path_.map.size() + 1);
    const std::size_t end = name_length(below, map_, chain, change.second.type == Node::Type::mapping);
    path_.joint = below.substr(0, end);
    if (path_.joint.empty())
      override_.refuse("a key of the path is empty", qerr::quoted(change.first),
                       "name a key, such as filters.velocity.lowpass.cutoff");
    path_.rest = below.substr(end + (end < below.size() && below[end] == '.'));
  }

  bool of_pattern() const { return is_pattern(path_.joint) && !find(path_.joint); }

  /// The joints that the change is made for.
  std::vector<std::string> joints() const {
    std::vector<std::string> names;
    for (const IndependentJoint& joint : chain_.independent)
      if (of_pattern() ? fits(path_.joint, joint.name) : joint.name == path_.joint)
        names.push_back(joint.name);
    return names;
  }

  /// Whether nothing of an earlier change is left at a joint that both are made for.
  bool replaces(const JointOverride& earlier) const {
    const std::string &now = path_.rest, &before = earlier.path_.rest;
    if (path_.map != earlier.path_.map || (before.empty() && !now.empty()) || now.starts_with(before + '.'))
      return false;
    return now.empty() || set_one_value(path_.map + ".j." + now, path_.map + ".j." + before);
  }

  /// Whether the user states it first: both are elements of one list of changes.
  bool is_stated_before(const JointOverride& other) const { return &value_ < &other.value_; }

  /// @param later  changes that are made behind this one
  void refuse_replaced(std::span<const JointOverride> later) const {
    std::vector<std::string> left = joints();
    if (left.empty()) return;
    std::string holding;
    for (const JointOverride& other : later) {
      if (!other.replaces(*this)) continue;
      const std::vector<std::string> of_other = other.joints();
      if (std::erase_if(left, [&](const std::string& name) { return contains(of_other, name); }) > 0)
        holding += (holding.empty() ? "" : ", ") + other.key();
    }
    if (left.empty())
      override_.refuse("governs nothing: " + holding + " holds for its joints", qerr::quoted(key()),
                       "leave one of them out");
  }

  std::string key() const {
    return path_.map + '.' + path_.joint + (path_.rest.empty() ? "" : '.' + path_.rest);
  }

  /// @param later  changes that are made behind this one
  /// @returns a warning, or ""
  std::string apply(std::span<const JointOverride> later) const {
    if (!of_pattern()) {
      refuse_unused();
      change(path_.joint);
      return "";
    }
    const bool own_entry = map_->find(path_.joint);
    std::string kept_of_names;
    std::vector<std::string> changed = governing(), kept;
    std::ranges::copy_if(changed, std::back_inserter(kept),
                         [&](const std::string& name) { return cannot_have(name); });
    if (kept.size() == changed.size()) kept.clear();  // the reader says what is wrong
    std::erase_if(changed, [&](const auto& name) { return std::ranges::count(kept, name) > 0; });
    for (const std::string& name : changed) change(name);
    std::erase(changed, path_.joint);
    for (const JointOverride& other : later) {
      if (other.of_pattern() || !other.replaces(*this) || !fits(path_.joint, other.path_.joint)) continue;
      std::erase(changed, other.path_.joint);
      if (other.is_stated_before(*this)) kept_of_names += (kept_of_names.empty() ? "" : ", ") + other.key();
    }
    const std::string also = own_entry && !changed.empty() ? " also changes " + list_of_names(changed) : "";
    const std::string not_these =
        kept.empty() ? "" : " does not change " + list_of_names(kept) + ", whose encoders cannot have it";
    const std::string named = kept_of_names.empty()
                                  ? ""
                                  : " does not change what " + kept_of_names +
                                        " states: a name beats a pattern, whatever their order";
    std::string all;
    for (const std::string& text : {also, not_these, named})
      if (!text.empty()) all += (all.empty() ? place_.file : ", and") + text;
    return all;
  }

 private:
  const IndependentJoint* find(const std::string& name) const { return find_named(chain_.independent, name); }

  /// The patterns among the entries that hold for a joint.
  std::vector<std::string> patterns_of(const std::string& joint) const {
    std::vector<std::string> patterns;
    if (map_->find(joint)) return patterns;
    for (const Node::Entry& entry : map_->entries)
      if (is_pattern(entry.key.name) && fits(entry.key.name, joint)) patterns.push_back(entry.key.name);
    return patterns;
  }

  /// Whether all joints that an entry's pattern governs fit the changed pattern.
  bool within(const std::string& entry) const {
    return std::ranges::all_of(chain_.independent, [&](const auto& joint) {
      const std::vector<std::string> patterns = patterns_of(joint.name);
      return !contains(patterns, entry) || fits(path_.joint, joint.name);
    });
  }

  /// The entries that govern the joints of the pattern. Of a wider pattern a joint gets a copy, and joints
  /// without an entry get one of the pattern itself.
  std::vector<std::string> governing() const {
    std::vector<std::string> entries;
    for (const IndependentJoint& joint : chain_.independent) {
      if (!fits(path_.joint, joint.name)) continue;
      const std::vector<std::string> patterns = patterns_of(joint.name);
      const bool own = contains(patterns, path_.joint);
      const std::string entry = map_->find(joint.name)     ? joint.name
                                : own || patterns.empty()  ? path_.joint
                                : within(patterns.front()) ? patterns.front()
                                                           : joint.name;
      add_once(entries, entry);
    }
    if (entries.empty())
      override_.refuse("the pattern fits no joint between base and tip", qerr::quoted(path_.joint),
                       did_you_mean(path_.joint, joint_names(chain_)));
    return entries;
  }

  bool gives(std::string_view key) const {
    return path_.rest.empty() ? value_.find(key) != nullptr : path_.rest == key;
  }

  /// Whether a joint's own entry cannot have the change: the gear ratio of a scale at the joint, the counts
  /// of a prismatic joint without its travel.
  bool cannot_have(const std::string& name) const {
    const IndependentJoint* const joint = find(name);
    const Node* const entry = map_->find(name);
    if (path_.map != "encoders" || !joint || !entry) return false;
    for (const EncoderKind& kind : encoder_kinds())
      if (gives(kind.name))
        return joint->prismatic() && kind.counts_per_rev && !gives("travel_per_rev") &&
               !entry->find("travel_per_rev");
    for (const EncoderKind& kind : encoder_kinds())
      if (entry->find(kind.name)) {
        const std::vector<Parameter> rows = encoder_parameters(kind);
        return is_encoder_key(path_.rest) && !find_named(rows, path_.rest);
      }
    return false;
  }

  /// An entry of a joint that is not part of the chain governs nothing.
  void refuse_unused() const {
    if (find(path_.joint) || !map_->find(path_.joint)) return;
    override_.refuse("governs nothing: the joint is not between base and tip", qerr::quoted(path_.joint),
                     did_you_mean(path_.joint, joint_names(chain_)));
  }

  void change(const std::string& name) const {
    Node* entry = map_->find(name);
    if (!entry) {
      map_->entries.push_back({{name, place_}, copied(name)});
      entry = &map_->entries.back().value;
    }
    if (path_.map == "encoders") exclude_other_keys(*entry, path_.rest);
    override_.apply(entry, path_.map + '.' + name, path_.rest);
  }

  /// What holds for a joint without an entry of its own: that of a pattern.
  Node copied(const std::string& name) const {
    const Node nothing{Node::Type::null, place_, {}, false, {}, {}};
    const IndependentJoint* const joint = find(name);
    const std::vector<std::string> patterns = joint ? patterns_of(name) : std::vector<std::string>{};
    if (patterns.empty() || path_.rest.empty()) return nothing;
    if (patterns.size() > 1)
      override_.refuse("two patterns fit joint " + qerr::quoted(name),
                       path_.map + '.' + patterns[0] + " and " + path_.map + '.' + patterns[1],
                       "set the whole entry: --set '" + path_.map + '.' + name + "={...}'");
    return *map_->find(patterns.front());
  }

  Override override_;
  const Node& value_;
  Place place_;
  const Chain& chain_;
  JointChange path_;
  Node* map_ = nullptr;
};

/// Applies changes of entries by joints: those of patterns first, as an entry of a joint may begin with a
/// copy of a pattern's, so that the order on the command line does not matter.
void apply_to_joints(Node& root, std::vector<SpecChange>::const_iterator begin,
                     std::vector<SpecChange>::const_iterator end, const Chain& chain,
                     std::vector<std::string>& warnings) {
  const auto made = [&] {
    std::vector<JointOverride> all;
    for (const bool patterns : {true, false})
      for (auto change = begin; change != end; ++change)
        if (!joint_map_of(change->first).empty())
          if (JointOverride override(root, *change, chain); override.of_pattern() == patterns)
            all.push_back(std::move(override));
    return all;
  };
  made();  // begins the mappings that are missing, so that those found next stay where they are
  const std::vector<JointOverride> all = made();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto later = std::span(all).subspan(i + 1);
    all[i].refuse_replaced(later);
    const std::string warning = all[i].apply(later);
    if (!warning.empty()) warnings.push_back(warning);
  }
}

/// Whether a change replaces a mapping by joints, or one in which it lies.
bool changes_map(const SpecChange& change) {
  return std::any_of(std::begin(joint_maps), std::end(joint_maps), [&](const std::string map) {
    return map == change.first || map.starts_with(change.first + '.');
  });
}

}  // namespace

bool set_one_value(const std::string& one, const std::string& other) {
  const std::string a = with_dots(one), b = with_dots(other);
  if ((a + '.').starts_with(b + '.') || (b + '.').starts_with(a + '.')) return true;
  const auto kind = [](const std::string& key) {
    return find_named(encoder_kinds(), key.substr(key.rfind('.') + 1)) != nullptr;
  };
  return a.starts_with("encoders.") && kind(a) && kind(b) &&
         a.substr(0, a.rfind('.')) == b.substr(0, b.rfind('.'));
}

std::vector<std::string> apply_changes(Node& root, const std::vector<SpecChange>& changes,
                                       const ChainOf& chain_of) {
  std::vector<std::string> warnings;
  const auto apply = [&](const SpecChange& change) { Override(change).apply(&root, "", change.first); };
  const auto of_joints = [](const SpecChange& change) {
    return changes_map(change) || !joint_map_of(change.first).empty();
  };
  // A change within a mapping that another change replaces must follow it, though its key names no joint:
  // configurations.count behind configurations={...}.
  const auto refines = [&](const SpecChange& change) {
    return !of_joints(change) && std::ranges::any_of(changes, [&](const SpecChange& whole) {
      return changes_map(whole) && change.first.starts_with(whole.first + '.');
    });
  };
  for (const SpecChange& change : changes)
    if (!of_joints(change) && !refines(change)) apply(change);
  for (auto begin = changes.begin(); begin != changes.end();) {
    const auto end = std::find_if(begin, changes.end(), changes_map);
    for (auto change = begin; change != end; ++change)
      if (refines(*change)) apply(*change);
    if (std::any_of(begin, end, [](const SpecChange& c) { return !joint_map_of(c.first).empty(); }))
      apply_to_joints(root, begin, end, chain_of(root), warnings);
    if (end != changes.end()) apply(*end);
    begin = end == changes.end() ? end : end + 1;
  }
  return warnings;
}

SpecChange spec_change(const std::string& path, const std::string& text, const std::string& origin) {
  const Place place{origin, 0, 0};
  if (path.find_first_not_of(' ') == std::string::npos)
    throw Error(place, path, "a key is missing", "", "such as filters.velocity.lowpass.cutoff");
  const std::size_t first = path.find_first_not_of(' '), last = path.find_last_not_of(' ');
  const std::string trimmed = path.substr(first, last + 1 - first);
  if (trimmed.ends_with('.'))
    throw Error(place, path, "the path ends with a point", "'" + trimmed + "'", "name the key after it");
  return {trimmed, value_of(text, trimmed, place)};
}

std::vector<SpecChange> spec_changes(const std::vector<std::pair<std::string, std::string>>& set) {
  std::vector<SpecChange> changes;
  for (const auto& [key, value] : set) changes.push_back(spec_change(key, value, "--set " + key));
  return changes;
}

}  // namespace qerr
