#include "input/extended_filters.hpp"

#include <algorithm>

namespace qerr {

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

}  // namespace

void add_filters(Node& root, const std::vector<NamedFilter>& present, const std::vector<AddedFilter>& added) {
  Node* filters = root.find("filters");
  const auto like =
      std::find_if(present.begin(), present.end(), [](const auto& f) { return f.filter.derivative == 1; });
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

}  // namespace qerr
