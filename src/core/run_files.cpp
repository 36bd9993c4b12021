#include "core/run_files.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <tuple>

#include "qerr/core/error.hpp"

namespace qerr {

namespace {

/// Device and inode of a file, or those of its folder and its name in there.
using Identity = std::tuple<dev_t, ino_t, std::string>;

struct Noted {
  std::map<Identity, std::string> inputs, outputs;  ///< with the names as given
  std::map<std::string, std::string> piped;         ///< texts by the names as given
  bool standard_output = false;
};

std::mutex guard;
std::optional<Noted> noted;

std::optional<Identity> identity_of(const struct stat& status) {
  if (!S_ISREG(status.st_mode)) return {};
  return Identity{status.st_dev, status.st_ino, ""};
}

std::optional<Identity> identity_of(const std::string& path, int stream) {
  struct stat status {};
  if (path == "-") return fstat(stream, &status) == 0 ? identity_of(status) : std::nullopt;
  if (stat(path.c_str(), &status) == 0) return identity_of(status);
  const std::filesystem::path file(link_target(path));
  const std::string folder = file.has_parent_path() ? file.parent_path().string() : ".";
  if (stat(folder.c_str(), &status) != 0) return {};
  return Identity{status.st_dev, status.st_ino, file.filename().string()};
}

[[noreturn]] void refuse(const std::string& path, const std::string& option, const std::string& rule,
                         const std::string& other, const std::string& remedy) {
  const std::string found = other.empty() || other == path ? "" : "'" + other + "', which is the same file";
  throw Error(Fault{{path}, option, rule, found, remedy}, Trouble::usage);
}

constexpr const char* overwriting = "an output must not be an input of the same command";
constexpr const char* rename_it = "give the output another name";

}  // namespace

std::string link_target(const std::string& path) {
  constexpr int most_links = 40;  // as the kernel's
  std::filesystem::path file(path);
  std::error_code none;
  for (int i = 0; i < most_links; ++i) {
    const std::filesystem::path target = std::filesystem::read_symlink(file, none);
    if (none) break;
    file = target.is_absolute() ? target : file.parent_path() / target;
  }
  return file.string();
}

RunFiles::RunFiles() {
  const std::lock_guard lock(guard);
  noted.emplace();
}

RunFiles::~RunFiles() {
  const std::lock_guard lock(guard);
  noted.reset();
}

void note_input(const std::string& path) {
  const std::lock_guard lock(guard);
  const auto identity = noted ? identity_of(path, STDIN_FILENO) : std::nullopt;
  if (!identity) return;
  const std::string name = path == "-" ? "(standard input)" : path;
  if (const auto output = noted->outputs.find(*identity); output != noted->outputs.end())
    refuse(output->second, "", overwriting, name, rename_it);
  noted->inputs.emplace(*identity, name);
}

std::optional<std::string> piped_text(const std::string& path) {
  const std::lock_guard lock(guard);
  if (!noted) return {};
  const auto text = noted->piped.find(path);
  return text == noted->piped.end() ? std::nullopt : std::optional(text->second);
}

void keep_piped(const std::string& path, const std::string& text) {
  const std::lock_guard lock(guard);
  if (noted) noted->piped[path] = text;
}

void note_output(const std::string& path, const std::string& option) {
  const std::lock_guard lock(guard);
  if (!noted) return;
  const std::string name = path == "-" ? "standard output" : path;
  if (path == "-" && std::exchange(noted->standard_output, true))
    refuse(name, option, "only one result can go to standard output", "",
           "name a file for the others, such as -o FILE");
  const auto identity = identity_of(path, STDOUT_FILENO);
  if (!identity) return;
  if (const auto input = noted->inputs.find(*identity); input != noted->inputs.end())
    refuse(name, option, overwriting, input->second, rename_it);
  const auto [other, is_new] = noted->outputs.emplace(*identity, name);
  if (!is_new)
    refuse(name, option, "two outputs must not be one file", other->second, "give each its own name");
}

}  // namespace qerr
