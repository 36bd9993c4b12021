#include "input/package_path.hpp"

#include <cstdlib>
#include <filesystem>
#include <vector>

#include "core/text.hpp"
#include "qerr/core/error.hpp"

namespace qerr {

namespace {

namespace fs = std::filesystem;

constexpr int most_depth = 5;                // of a package below a folder of ROS_PACKAGE_PATH
constexpr std::size_t most_folders = 20000;  // looked at below one of them

Error not_found(const std::string& given, const std::string& rule, const std::string& remedy) {
  return Error(Fault{{}, "", rule, quoted(given), remedy});
}

std::vector<fs::path> folders_of(const char* variable) {
  std::vector<fs::path> folders;
  const char* value = std::getenv(variable);
  const std::string list = value ? value : "";
  for (std::size_t begin = 0; begin < list.size();) {
    const std::size_t end = std::min(list.find(':', begin), list.size());
    if (end > begin) folders.emplace_back(list.substr(begin, end - begin));
    begin = end + 1;
  }
  return folders;
}

bool is_package(const fs::path& folder) {
  std::error_code ignored;
  return fs::exists(folder / "package.xml", ignored) || fs::exists(folder / "manifest.xml", ignored);
}

/// The packages of this name at or below a folder, found as rospack does: packages do not contain packages.
void search(const fs::path& folder, const std::string& package, std::vector<fs::path>& found) {
  std::error_code wrong;
  const fs::path whole = fs::weakly_canonical(folder, wrong);
  if (whole.filename() == package || fs::is_directory(folder / package, wrong))
    found.push_back(whole.filename() == package ? whole : folder / package);
  fs::recursive_directory_iterator walk(folder, fs::directory_options::skip_permission_denied, wrong);
  for (std::size_t seen = 0; !wrong && walk != fs::recursive_directory_iterator() && seen < most_folders;
       walk.increment(wrong), ++seen) {
    const fs::path& path = walk->path();
    if (!walk->is_directory(wrong)) continue;
    const bool package_here = is_package(path);
    if (package_here && path.filename() == package) found.push_back(path);
    if (package_here || walk.depth() >= most_depth || path.filename().string().starts_with('.'))
      walk.disable_recursion_pending();
  }
}

std::string in_package(const std::string& given, const std::string& package, const std::string& path) {
  const auto ament = folders_of("AMENT_PREFIX_PATH"), ros = folders_of("ROS_PACKAGE_PATH");
  if (ament.empty() && ros.empty())
    throw not_found(given,
                    "the package cannot be looked up: AMENT_PREFIX_PATH and ROS_PACKAGE_PATH are not set",
                    "source the setup file of the ROS workspace, or give a path relative to the spec");
  std::vector<fs::path> found;
  std::error_code ignored;
  for (const fs::path& prefix : ament)
    if (fs::is_directory(prefix / "share" / package, ignored)) found.push_back(prefix / "share" / package);
  for (const fs::path& folder : ros) search(folder, package, found);
  for (const fs::path& folder : found)
    if (fs::exists(folder / path, ignored)) return (folder / path).string();
  if (found.empty())
    throw not_found(given,
                    "package '" + package + "' is in no folder of AMENT_PREFIX_PATH or ROS_PACKAGE_PATH",
                    "is it built and its workspace sourced?");
  throw not_found(given, "package '" + package + "' has no file '" + path + "'",
                  "the package is " + found.front().string());
}

}  // namespace

std::string urdf_path(const std::string& given, const std::string& folder) {
  const std::size_t colon = given.find("://");
  if (colon == std::string::npos) return (fs::path(folder) / given).string();
  const std::string scheme = given.substr(0, colon), rest = given.substr(colon + 3);
  if (scheme == "file") return rest;
  const std::size_t slash = rest.find('/');
  if (scheme == "package" && slash != std::string::npos && slash > 0 && slash + 1 < rest.size())
    return in_package(given, rest.substr(0, slash), rest.substr(slash + 1));
  throw not_found(given, "robot.urdf must be a path, package://PACKAGE/PATH or file:///PATH", "");
}

}  // namespace qerr
