#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "input/urdf_outline.hpp"
#include "qerr/kinematics/robot_model.hpp"

namespace qerr {

/// The flaws of one document, each with the part of the robot that it concerns.
class FlawList {
 public:
  explicit FlawList(std::string file) : file_(std::move(file)) {}

  /// Further flaws concern this child of `<robot>`: a joint, a link, or the document for any other element.
  void concern(const UrdfElement& element);
  /// Further flaws concern the joint of this name.
  void concern_joint(const std::string& name) { concern_joints({name}); }
  void concern_joints(std::vector<std::string> names) {
    part_ = Flaw{.fault = {}, .joints = std::move(names)};
  }
  void concern_document() { part_ = {}; }

  /// A flaw after which the part cannot be used.
  /// @throws Error with all of them when they are very many
  template <class Located>
  Flaw& spoil(const Located& at, std::string key, std::string rule, std::string found, std::string remedy) {
    return add(
        true,
        {{file_, at.line, at.column}, std::move(key), std::move(rule), std::move(found), std::move(remedy)});
  }

  /// A flaw that no figure depends on.
  template <class Located>
  void warn(const Located& at, std::string key, std::string rule, std::string found = {},
            std::string remedy = {}) {
    add(false,
        {{file_, at.line, at.column}, std::move(key), std::move(rule), std::move(found), std::move(remedy)});
  }

  void raise() const;  ///< @throws Error with the flaws that spoil a part, if there is any
  std::vector<Flaw> take() { return std::move(flaws_); }

 private:
  Flaw& add(bool spoils, Fault fault);

  std::string file_;
  Flaw part_;
  std::vector<Flaw> flaws_;
  std::size_t spoiling_ = 0;
};

/// Allowed contents of an element: `many` and `once` are read, `whole` is kept with all that it contains,
/// `ignored` is skipped. Any other name is foreign (a tag of a simulator) unless it resembles a known one.
struct Vocabulary {
  using Names = std::vector<std::string>;
  std::string_view element;
  Names many, once, whole, ignored, attributes;

  static bool has(const Names& names, std::string_view name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  }
};

/// The row of an element; null if the element has none.
const Vocabulary* vocabulary(std::string_view element);

/// Reports misspelt and duplicate elements and attributes, which a lenient reader would skip silently.
/// @throws Error (input) for values that xacro has not expanded
void check_vocabulary(const UrdfElement& root, const std::string& file, FlawList&);

}  // namespace qerr
