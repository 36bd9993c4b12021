#include "input/moved_paths.hpp"

#include <algorithm>
#include <filesystem>
#include <functional>

#include "input/spec_format.hpp"

namespace qerr {

namespace {

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

}  // namespace

void move_paths(Node& root, const std::string& from, const std::string& to) {
  const PathChange move = [&](std::string& path) { path = moved(path, folder_of(from), folder_of(to)); };
  for (const std::string_view key : spec_format::file_keys()) move_below(root, key, move);
  if (Node* const sweep = root.find("sweep"))
    for (Node& axis : sweep->items) move_swept(axis, move);
}

}  // namespace qerr
