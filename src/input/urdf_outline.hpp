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

/// An element of the kinematic part of a URDF; at most four levels deep, so that recursion is safe.
struct UrdfElement {
  std::string name;
  int line = 0, column = 0;
  std::vector<UrdfAttribute> attributes;
  std::vector<UrdfElement> children;

  const UrdfAttribute* attribute(std::string_view wanted) const;
  const UrdfElement* child(std::string_view wanted) const;
  /// The name used in messages: `joint 'elbow'`, or `joint` if it has no name.
  std::string title() const;
};

/// Faults of one document; throws when there are more than a message shows.
class FaultList {
 public:
  explicit FaultList(std::string file) : file_(std::move(file)) {}
  void add(int line, int column, std::string key, std::string rule, std::string found, std::string remedy);
  void raise() const;  ///< @throws Error if there is any fault

 private:
  std::string file_;
  std::vector<Fault> faults_;
};

/// The `<robot>` with its links, inertials, joints and the children of joints; other elements are skipped.
///
/// Read by expat, because urdfdom reports neither lines nor columns, and silently skips misspelt elements and
/// attributes.
/// @throws Error (input) with line and column for malformed XML, a DTD, extreme depth or size, another kind
/// of document (SDF, unexpanded xacro), and for unknown elements or attributes that resemble a known one
UrdfElement urdf_outline(const std::string& text, const std::string& file);

}  // namespace qerr
