#include "input/extended_filters.hpp"

#include <algorithm>

namespace qerr {

namespace {

Node scalar(const std::string& text) { return {Node::Type::scalar, {}, text, false, {}, {}}; }

Node mapping(std::vector<std::pair<std::string, Node>> entries) {
  Node node{Node::Type::mapping, {}, {}, false, {}, {}};
  for (auto& [key, value] : entries) node.entries.emplace_back(Node::Key{key, {}}, std::move(value));
  return node;
}

Node* entry(Node& holder, const std::string& key) {
  for (auto& [name, value] : holder.entries)
    if (name.name == key) return &value;
  return nullptr;
}

Node lowpass(const AddedFilter& f) {
  return mapping({{"family", scalar(f.family)},
                  {"order", scalar(std::to_string(f.order))},
                  {"cutoff", scalar(shortest(f.cutoff) + " Hz")}});
}

/// As the spec writes it, `1 kHz`, where it does so by this key.
Node sample_rate(Node& filters, const NamedFilter& like) {
  const Node* written = entry(filters, like.name) ? entry(filters, like.name)->find("sample_rate") : nullptr;
  return written ? *written : scalar(shortest(like.filter.sample_rate) + " Hz");
}

}  // namespace

void add_filters(Node& root, const std::vector<NamedFilter>& present, const std::vector<AddedFilter>& added) {
  Node* filters = entry(root, "filters");
  const auto like =
      std::find_if(present.begin(), present.end(), [](const auto& f) { return f.filter.derivative == 1; });
  if (!filters || like == present.end()) return;
  for (const AddedFilter& f : added) {
    Node* there = entry(*filters, f.name);
    if (Node* old = there ? entry(*there, "lowpass") : nullptr) {
      *old = lowpass(f);
      continue;
    }
    Node node = mapping({{"derivative", scalar("1")},
                         {"sample_rate", sample_rate(*filters, *like)},
                         {"lowpass", lowpass(f)}});
    node.comment = f.note;
    if (there)
      *there = std::move(node);
    else
      filters->entries.emplace_back(Node::Key{f.name, {}}, std::move(node));
  }
}

}  // namespace qerr
