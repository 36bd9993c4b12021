#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <utility>
#include <vector>

#include "core/lists.hpp"
#include "core/solve.hpp"
#include "effect/effects/effects.hpp"
#include "input/read_sections.hpp"
#include "input/spec_variants.hpp"
#include "input/yaml_tree.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {
/// Writes filters into the `filters:` of a spec's tree.
///
/// A filter of the same name keeps everything but its low-pass; a new one has derivative and sample rate of
/// the first filter that estimates a velocity.
void add_filters(Node& root, const std::vector<NamedFilter>& present, const std::vector<AddedFilter>&);

namespace {

Node lowpass(const AddedFilter& f) {
  return mapping_node({{"family", scalar_node(f.family)},
                       {"order", scalar_node(std::to_string(f.order))},
                       {"cutoff", scalar_node(shortest(f.cutoff) + " Hz")}});
}

/// The sample rate as the spec writes it, such as `1 kHz`, if the filter `like` has that key.
Node sample_rate(Node& filters, const NamedFilter& like) {
  const Node* written = filters.find(like.name) ? filters.find(like.name)->find("sample_rate") : nullptr;
  return written ? *written : scalar_node(shortest(like.filter.sample_rate) + " Hz");
}

namespace fs = std::filesystem;

fs::path folder_of(const std::string& file) {
  const fs::path parent = file == "-" ? fs::path() : fs::path(file).parent_path();
  return parent.empty() ? fs::path(".") : parent;
}

/// The path of the same file relative to the folder `to` of the new spec. Symbolic links are resolved, since
/// `..` after a link refers to the link's target.
std::string moved(const std::string& path, const fs::path& from, const fs::path& to) {
  const bool package = path.find("://") != std::string::npos;
  if (package || fs::path(path).is_absolute()) return path;
  std::error_code wrong;
  const fs::path old_folder = fs::canonical(from, wrong);
  const fs::path new_folder = wrong ? fs::path() : fs::canonical(to, wrong);
  if (wrong || old_folder == new_folder) return path;
  const fs::path file = old_folder / path;
  const fs::path folder = fs::canonical(file.parent_path(), wrong);
  return wrong ? path : (folder / file.filename()).lexically_relative(new_folder).generic_string();
}

using PathChange = std::function<void(std::string&)>;

/// Moves the paths at a key below a node: `urdf`, `encoders.*.catalogue`, `[].catalogue`.
void move_below(Node& node, std::string_view key, const PathChange& move) {
  if (key.empty()) {
    if (node.type == Node::Type::scalar) move(node.text);
    return;
  }
  const std::size_t length = key.starts_with("[]") ? 2 : std::min(key.find_first_of(".["), key.size());
  const std::string_view step = key.substr(0, length);
  key.remove_prefix(std::min(key.size(), length + (key.substr(length).starts_with('.') ? 1 : 0)));
  if (step == "[]")
    for (Node& item : node.items) move_below(item, key, move);
  for (Node::Entry& entry : node.entries)
    if (step == "*" || step == entry.key.name) move_below(entry.value, key, move);
}

/// The values that a sweep gives to such keys, or to sections that have them.
void move_swept(Node& axis, const PathChange& move) {
  const Node *const one = axis.find("key"), *const several = axis.find("keys");
  Node* const values = axis.find("values");
  if (!values || (!one && !several)) return;
  const std::vector<Node> keys = one ? std::vector<Node>{*one} : several->items;
  for (std::size_t k = 0; k < keys.size(); ++k)
    for (std::string_view path : spec_format::file_keys()) {
      if (!path.starts_with(keys[k].text) || !spec_format::may_name_a_file(keys[k].text)) continue;
      path.remove_prefix(std::min(path.size(), keys[k].text.size() + 1));
      for (Node& value : values->items)
        if (one || k < value.items.size()) move_below(one ? value : value.items[k], path, move);
    }
}

/// Rewrites the paths of a spec's tree, which are relative to the spec, for a spec that stands elsewhere.
/// @param from, to  paths of the specs; `-` is in the working folder
void move_paths(Node& root, const std::string& from, const std::string& to) {
  const PathChange move = [&](std::string& path) { path = moved(path, folder_of(from), folder_of(to)); };
  for (const std::string_view key : spec_format::file_keys()) move_below(root, key, move);
  if (Node* const sweep = root.find("sweep"))
    for (Node& axis : sweep->items) move_swept(axis, move);
}

/// An entry of `effects:`: keys in the order of the row, SI numbers that read back as the same double.
Node node_of(const AddedEffect& added, const EffectKind& kind) {
  Node node{Node::Type::mapping, {}, {}, false, {}, {}, added.note};
  const auto add = [&](std::string_view key, const std::string& text) {
    node.entries.push_back({{std::string(key), {}}, scalar_node(text)});
  };
  add("type", added.effect.type);
  add("joint", added.effect.joint);
  for (const Parameter& row : kind.parameters) {
    const auto number = added.effect.numbers.find(std::string(row.name));
    if (number != added.effect.numbers.end() && row.fallback != number->second)
      // Parameters of integer kind are estimated as real numbers.
      add(row.name, shortest(row.kind == Kind::integer ? std::round(number->second) : number->second));
    const auto choice = added.effect.choices.find(std::string(row.name));
    if (choice != added.effect.choices.end()) add(row.name, choice->second);
  }
  return node;
}

/// Key of `robot` that states a displaced tool or tracker; "" for an effect.
std::string pose_key(const Effect& effect) {
  if (effect.type == tool_effect().name) return effect.type;
  return effect.type == frame_effect().name ? "tracker" : "";
}

void set_key(Node& map, const std::string& key, Node value) {
  if (Node* present = map.find(key))
    *present = std::move(value);
  else
    map.entries.push_back({{key, {}}, std::move(value)});
}

template <class Numbers>
Node list_node(const Numbers& numbers) {
  Node list{Node::Type::sequence, {}, {}, false, {}, {}};
  for (const double number : numbers) list.items.push_back(scalar_node(shortest(number)));
  return list;
}

/// Moves robot.tool to the point that was tracked, which is found in the axes of the tip, or robot.tracker to
/// the frame that was found in the axes of the stated one.
void move_pose(Node& root, const std::string& key, const Effect& found) {
  Node* robot = root.find("robot");
  if (!robot || robot->type != Node::Type::mapping) return;
  if (!robot->find(key)) robot->entries.push_back({{key, {}}, mapping_node({})});
  Node& stated = *robot->find(key);
  Eigen::Isometry3d pose = read_pose(Field{&stated, "robot." + key});
  const Eigen::Vector3d xyz(found.number("x"), found.number("y"), found.number("z"));
  if (found.type == tool_effect().name) {
    set_key(stated, "xyz", list_node(pose * xyz));
    return;
  }
  const Eigen::Vector3d turn(found.number("rx"), found.number("ry"), found.number("rz"));
  Eigen::Isometry3d moved = Eigen::Translation3d(xyz) * Eigen::Isometry3d::Identity();
  if (turn.norm() > 0) moved.rotate(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
  pose = moved * pose;
  set_key(stated, "xyz", list_node(pose.translation()));
  set_key(stated, "rpy", list_node(roll_pitch_yaw(pose.linear())));
}

bool is_coupling(const Effect& effect) { return effect.type == coupling_error_effect().name; }

/// States the coupling with what encoders were found to follow of other joints: encoder coordinates = C^-1
/// joints, to which each adds its factor.
void state_coupling(Node& root, const Spec& spec, const std::vector<Effect>& found) {
  const Chain& chain = spec.model.chain;
  const auto number = [&](const std::string& joint) { return independent_index(chain, joint); };
  Eigen::MatrixXd to_encoders = spec.model.transmission.coupling.inverse().dense();
  for (const Effect& e : found)
    to_encoders(number(e.joint), number(e.choices.at("of"))) += e.number("factor");
  Node rows{Node::Type::sequence, {}, {}, false, {}, {}};
  const Eigen::MatrixXd to_joints = inverse(to_encoders);
  for (Eigen::Index i = 0; i < to_joints.rows(); ++i) rows.items.push_back(list_node(to_joints.row(i)));
  set_key(root, "coupling", std::move(rows));
}

/// Why an effect cannot be written into a spec; "" if it can.
std::string obstacle(const Effect& effect) {
  if (!find_named(effect_kinds(), effect.type) && pose_key(effect).empty() && !is_coupling(effect))
    return "not an effect that can be simulated";
  for (const auto& [name, value] : effect.numbers)
    if (!std::isfinite(value)) return name + " is not known";
  return "";
}

/// The text of a spec with added effects and filters.
class Extension {
 public:
  Extension(const Spec& spec, const std::string& remarks, const std::string& target,
            const std::vector<AddedFilter>& filters)
      : spec_(spec), remarks_(remarks), target_(target), filters_(filters) {}

  void add(const AddedEffect& effect) {
    // What is wrong at the tip alone is wrong at every joint: the delay of the tracker's stamps. A pattern
    // would yield to an entry of the same type that names its joint.
    if (effect.effect.joint == "tip" && pose_key(effect.effect).empty() &&
        !find_joint(spec_.model.chain, "tip")) {
      AddedEffect of_joint = effect;
      for (const IndependentJoint& joint : spec_.model.chain.independent) {
        of_joint.effect.joint = joint.name;
        add(of_joint);
        of_joint.note.clear();
      }
      return;
    }
    const std::string why = obstacle(effect.effect);
    if (why.empty())
      accepted_.push_back(effect);
    else
      omit(effect, why);
  }

  std::string text() {
    describe_filters();
    std::string out = written(accepted_);
    if (!accepted_.empty() && !fault_in(out).empty()) {
      // At least one is rejected; reading each alone shows which.
      std::vector<AddedEffect> good;
      for (const AddedEffect& effect : accepted_) {
        const std::string why = fault_in(written({effect}));
        why.empty() ? good.push_back(effect) : omit(effect, why);
      }
      out = written(accepted_ = good);
    }
    parse_spec(out, target_);
    return out;
  }

 private:
  void omit(const AddedEffect& effect, const std::string& why) {
    omitted_ += commented("found, but not part of this model: " + effect.effect.type + " of " +
                              effect.effect.joint + " (" + why + ")\n  " + effect.note,
                          "");
  }

  /// Comments on the filters: one that replaces the low-pass of a present filter has no entry of its own to
  /// carry its note.
  void describe_filters() {
    const std::string why = filters_.empty() ? "" : fault_in(written({}));
    for (const AddedFilter& f : filters_) {
      const bool present = find_named(spec_.filters, f.name);
      if (!why.empty())
        omitted_ += commented(
            "found, but not part of this model: filter " + f.name + " (" + why + ")\n  " + f.note, "");
      else if (present)
        omitted_ += commented("filters." + f.name + ": " + f.note, "");
    }
    if (!why.empty()) filters_.clear();
  }

  std::string fault_in(const std::string& text) const {
    try {
      parse_spec(text, target_);
    } catch (const Error& e) {
      const Fault& fault = e.faults().front();
      return fault.key + ": " + fault.rule + (fault.found.empty() ? "" : ", found " + fault.found);
    }
    return "";
  }

  std::string written(const std::vector<AddedEffect>& effects) const {
    Node root = parse_yaml(spec_.text, spec_.file);
    apply_changes(root, spec_changes(spec_.overrides),
                  [&](const Node&) -> const Chain& { return spec_.model.chain; });
    move_paths(root, spec_.file, target_);
    add_filters(root, spec_.filters, filters_);
    bool first = true;
    std::string elsewhere;
    std::vector<Effect> couplings;
    for (const AddedEffect& added : effects) {
      if (is_coupling(added.effect)) {
        couplings.push_back(added.effect);
        elsewhere += commented("coupling: " + added.note, "");
        continue;
      }
      if (const std::string key = pose_key(added.effect); !key.empty()) {
        move_pose(root, key, added.effect);
        elsewhere += commented("robot." + key + ": " + added.note, "");
        continue;
      }
      if (!root.find("effects"))
        root.entries.push_back({{"effects", {}}, Node{Node::Type::sequence, {}, {}, false, {}, {}}});
      Node& list = *root.find("effects");
      list.items.push_back(node_of(added, *find_named(effect_kinds(), added.effect.type)));
      if (std::exchange(first, false)) list.items.back().comment = remarks_ + '\n' + added.note;
    }
    if (!couplings.empty()) state_coupling(root, spec_, couplings);
    std::string out = rewritten(spec_.text, root, spec_.file);
    if (!out.ends_with('\n')) out += '\n';
    if (first) out += commented(remarks_, "");
    return out + elsewhere + omitted_;
  }

  const Spec& spec_;
  std::string remarks_, target_, omitted_;
  std::vector<AddedEffect> accepted_;
  std::vector<AddedFilter> filters_;
};

}  // namespace

void add_filters(Node& root, const std::vector<NamedFilter>& present, const std::vector<AddedFilter>& added) {
  Node* filters = root.find("filters");
  const auto like = std::ranges::find_if(present, [](const auto& f) { return f.filter.derivative == 1; });
  if (!filters || like == present.end()) return;
  for (const AddedFilter& f : added) {
    Node* present_entry = filters->find(f.name);
    if (Node* old_lowpass = present_entry ? present_entry->find("lowpass") : nullptr) {
      *old_lowpass = lowpass(f);
      continue;
    }
    Node node = mapping_node({{"derivative", scalar_node("1")},
                              {"sample_rate", sample_rate(*filters, *like)},
                              {"lowpass", lowpass(f)}});
    node.comment = f.note;
    if (present_entry)
      *present_entry = std::move(node);
    else
      filters->entries.push_back({{f.name, {}}, std::move(node)});
  }
}

std::string changed_spec(const Spec& spec, const std::vector<SpecChange>& changes,
                         const std::vector<Node>& effects, const std::string& remark,
                         const std::string& target) {
  Node root = parse_yaml(spec.text, spec.file);
  std::vector<SpecChange> all = spec_changes(spec.overrides);
  all.insert(all.end(), changes.begin(), changes.end());
  apply_changes(root, all, [&](const Node&) -> const Chain& { return spec.model.chain; });
  for (const Node& effect : effects) add_effect(root, effect);
  move_paths(root, spec.file, target);
  std::vector<std::string> replaced;
  for (const SpecChange& change : changes) replaced.push_back(change.first);
  std::string out = rewritten(spec.text, root, spec.file, replaced);
  if (!out.ends_with('\n')) out += '\n';
  return out + commented(remark, "");
}

std::string extended_spec(const Spec& spec, const std::vector<AddedEffect>& effects,
                          const std::string& remarks, const std::string& target,
                          const std::vector<AddedFilter>& filters) {
  Extension extension(spec, remarks, target, filters);
  for (const AddedEffect& effect : effects) extension.add(effect);
  return extension.text();
}

}  // namespace qerr
