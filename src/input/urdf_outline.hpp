#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "qerr/core/error.hpp"

namespace qerr {

struct UrdfAttribute {
  std::string name, value;
  int line = 0, column = 0;
};

/// An element of a URDF; at most 256 levels deep, so that recursion is safe.
struct UrdfElement {
  std::string name;
  int line = 0, column = 0;
  std::vector<UrdfAttribute> attributes;
  std::vector<UrdfElement> children;
  std::string text = {};  ///< between the tags; of transmissions only

  const UrdfAttribute* attribute(std::string_view wanted) const;
  const UrdfElement* child(std::string_view wanted) const;
  /// The name used in messages: `joint 'elbow'`, or `joint` if it has no name.
  std::string title() const;
};

/// The `<robot>` with its links, inertials, joints and the children of joints, and with its transmissions
/// wholly; other elements are skipped.
///
/// Read by expat, because urdfdom reports neither lines nor columns, and silently skips misspelt elements and
/// attributes.
/// @throws Error (input) with line and column for malformed XML, a DTD, extreme depth or size, and another
/// kind of document (SDF, unexpanded xacro)
UrdfElement urdf_outline(const std::string& text, const std::string& file);

}  // namespace qerr
