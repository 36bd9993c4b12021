#include "input/spec_variants.hpp"

#include <algorithm>

#include "input/yaml_text.hpp"

namespace qerr {

namespace {

/// The section of a dotted path.
std::string section_of(const SpecChange& change) {
  return change.first.substr(0, change.first.find_first_of(".["));
}

bool contains(const std::vector<std::string>& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// Sections that say how designs are found, not what they are.
bool is_search(const std::string& section) { return section == "sweep" || section == "design"; }

}  // namespace

void add_effect(Node& root, const Node& effect) {
  Node* list = root.find("effects");
  if (!list) {
    root.entries.push_back({{"effects", effect.place}, {}});
    list = &root.entries.back().value;
    list->type = Node::Type::sequence;
    list->place = effect.place;
  }
  const auto same = [&](const Node& other, std::string_view key) {
    const Node *const a = other.find(key), *const b = effect.find(key);
    return a && b && a->text == b->text;
  };
  const auto found = std::find_if(list->items.begin(), list->items.end(), [&](const Node& other) {
    return same(other, "type") && same(other, "joint");
  });
  if (found == list->items.end())
    list->items.push_back(effect);
  else
    *found = effect;
}

SpecVariants::SpecVariants(const std::string& text, const std::string& path, const SpecOverrides& overrides)
    : overrides_(spec_changes(overrides.values)),
      seed_(overrides.seed),
      reader_(path),
      base_(parse_spec(text, path, overrides)) {
  std::erase_if(overrides_, [](const SpecChange& change) { return is_search(section_of(change)); });
  root_ = parse_yaml(text, path);
  std::erase_if(root_.entries, [](const Node::Entry& entry) { return is_search(entry.key.name); });
  Node root = root_;
  warnings_ = apply_changes(root, overrides_, reader_.chain_of());
  reader_.read(root);
}

Spec SpecVariants::variant(const std::vector<SpecChange>& changes, const std::vector<Node>& effects) const {
  std::vector<std::string> changed;
  for (const SpecChange& change : changes)
    if (!contains(changed, section_of(change))) changed.push_back(section_of(change));
  if (!effects.empty() && !contains(changed, "effects")) changed.emplace_back("effects");
  const bool whole = std::any_of(changed.begin(), changed.end(),
                                 [](const std::string& s) { return !SpecReader::can_change(s); });
  Node root = mapping_node({});
  root.place = root_.place;
  const auto wanted = [&](const std::string& section) {
    return whole || SpecReader::reads_again(section, changed);
  };
  for (const Node::Entry& entry : root_.entries)
    if (wanted(entry.key.name)) root.entries.push_back(entry);
  std::vector<SpecChange> all;
  for (const SpecChange& override : overrides_)
    if (wanted(section_of(override))) all.push_back(override);
  all.insert(all.end(), changes.begin(), changes.end());
  SpecReader reader(base_.file);
  const auto base_chain = [&](const Node&) -> const Chain& { return base_.model.chain; };
  std::vector<std::string> warnings =
      apply_changes(root, all, whole ? reader.chain_of() : ChainOf(base_chain));
  for (const std::string& of_base : warnings_)
    if (!contains(warnings, of_base)) warnings.push_back(of_base);
  for (const Node& effect : effects) add_effect(root, effect);

  Spec spec = whole ? reader.read(root) : reader_.reread(root, changed);
  spec.warnings.insert(spec.warnings.begin(), warnings.begin(), warnings.end());
  spec.text = base_.text;
  spec.sha256 = base_.sha256;
  spec.overrides = base_.overrides;
  for (const auto& [key, value] : changes) spec.overrides.emplace_back(key, flow(value));
  if (seed_) spec.configurations.seed = *seed_;
  return spec;
}

}  // namespace qerr
