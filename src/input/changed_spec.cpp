#include "input/changed_spec.hpp"

#include "input/moved_paths.hpp"
#include "input/spec_variants.hpp"
#include "input/yaml_text.hpp"

namespace qerr {

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

}  // namespace qerr
