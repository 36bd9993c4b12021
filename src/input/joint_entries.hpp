#pragma once

#include <map>
#include <string>
#include <vector>

#include "input/read_sections.hpp"
#include "qerr/encoder/encoder.hpp"

namespace qerr {

std::vector<std::string> joint_names(const Chain&);

/// The index of the independent joint of this name.
/// @throws Error if the name is unknown, or belongs to a fixed joint, a mimic joint (the message names the
/// joint it mimics) or a joint outside the chain
std::size_t find_joint(const RobotModel&, const Chain&, const std::string& name, const Place&,
                       const std::string& path);

/// Whether the joint exists and moves but is not part of the chain: an entry for it is not used.
bool off_chain(const RobotModel&, const Chain&, const std::string& name);

/// `'a', 'b' and 3 more`, for messages.
std::string list_of_names(const std::vector<std::string>&);

/// Whether a key may be a pattern of joint names: it contains `*`, `?` or `[`.
bool is_pattern(const std::string& key);

/// Whether a joint's name fits a glob pattern: `*` any text, `?` one character, `[1-3]` one of a range.
bool fits(const std::string& pattern, const std::string& name);

/// The independent joints of the chain that a joint's name or a pattern stands for.
/// @throws Error like find_joint; for a pattern that fits no joint, with the joints' names
std::vector<std::size_t> find_joints(const RobotModel&, const Chain&, const std::string& name_or_pattern,
                                     const Place&, const std::string& path);

/// The entry of one joint in a mapping by joints: its own, or that of the pattern that fits it.
struct JointEntry {
  Field own;                    ///< its node is null without an entry under the joint's name
  std::vector<Field> patterns;  ///< entries of the patterns that fit the joint, in the order of the spec

  bool given() const { return own.node || !patterns.empty(); }
  /// @pre given
  const Field& holding() const { return own.node ? own : patterns.front(); }
};

/// The entries of all independent joints, in chain order. A joint's name beats a pattern; two patterns that
/// fit a joint without an entry of its own are a fault that names both. An entry of joints that are not
/// between base and tip is not used, with a warning.
std::vector<JointEntry> joint_entries(const Field& map, const RobotModel&, Spec&, Faults&);

/// Faults of entries that are read once for each of their joints: a fault that several joints have is
/// reported once, and names its joints if the entry's other joints do not have it.
class EntryFaults {
 public:
  /// Runs `read` for a joint and keeps its faults.
  template <class Read>
  void guard(const IndependentJoint& joint, const Field& entry, Read read) {
    ++joints_[entry.path];
    try {
      read();
    } catch (const Error& e) {
      if (e.trouble() != Trouble::input) throw;
      for (const Fault& fault : e.faults()) add(fault, joint, entry.path);
    }
  }

  /// @throws Error (input) with all faults, if there are any
  void raise() const;

 private:
  struct Shared {
    Fault fault;
    std::vector<std::string> joints;
    std::string entry;
  };
  void add(const Fault&, const IndependentJoint&, const std::string& entry);

  std::vector<Shared> faults_;
  std::map<std::string, std::size_t> joints_;  ///< read, by the path of their entry
};

/// The first kind that is stated at the joint, or at the encoder's shaft: of examples in messages.
const EncoderKind& first_kind(bool at_joint);

/// The keys of all kinds, each once.
std::vector<std::string> encoder_keys();
bool is_encoder_key(const std::string& key);

/// The kind of an encoder's entry, whose keys all belong to it.
/// @throws Error (input) if the entry is no mapping, states no kind or two, or has a key that is unknown,
/// ambiguous among vendors or of another kind
const EncoderKind& encoder_kind_of(const Field&);

}  // namespace qerr
