#include "input/moved_paths.hpp"

#include <filesystem>

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
  if (fs::path(path).is_absolute()) return path;
  std::error_code wrong;
  const fs::path old_folder = fs::canonical(from, wrong);
  const fs::path new_folder = wrong ? fs::path() : fs::canonical(to, wrong);
  if (wrong || old_folder == new_folder) return path;
  const fs::path file = old_folder / path;
  const fs::path folder = fs::canonical(file.parent_path(), wrong);
  return wrong ? path : (folder / file.filename()).lexically_relative(new_folder).generic_string();
}

}  // namespace

void move_paths(Node& root, const std::string& from, const std::string& to) {
  for (const auto& [section, key] :
       {std::pair{"robot", "urdf"}, {"motion", "file"}, {"configurations", "file"}}) {
    Node* place = root.find(section);
    Node* path = place ? place->find(key) : nullptr;
    if (path && path->type == Node::Type::scalar)
      path->text = moved(path->text, folder_of(from), folder_of(to));
  }
  Node* const design = root.find("design");
  Node* const options = design ? design->find("encoders") : nullptr;
  if (!options) return;
  for (Node::Entry& entry : options->entries)
    if (Node* path = entry.value.find("catalogue"); path && path->type == Node::Type::scalar)
      path->text = moved(path->text, folder_of(from), folder_of(to));
}

}  // namespace qerr
