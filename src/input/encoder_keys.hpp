#pragma once

#include <string>
#include <vector>

#include "input/joint_entries.hpp"
#include "input/read_sections.hpp"
#include "qerr/encoder/encoder.hpp"

namespace qerr {

/// The first kind that is stated at the joint, or at the encoder's shaft: of examples in messages.
const EncoderKind& first_kind(bool at_joint);

/// The keys of all kinds, each once.
std::vector<std::string> encoder_keys();
bool is_encoder_key(const std::string& key);

/// The keys of a kind and all common ones, also those that it has no use for.
std::vector<Parameter> all_keys_of(const EncoderKind&);

/// The kind of an encoder's entry, whose keys all belong to it.
/// @throws Error (input) if the entry is no mapping, states no kind or two, or has a key that is unknown,
/// ambiguous among vendors or of another kind
const EncoderKind& encoder_kind_of(const Field&);

/// @throws Error (input) if the section `encoders` describes one encoder, without the names of joints
void refuse_bare_encoder(const Field&, const Chain&);

/// Compares a joint's own encoder entry with the patterns that it overrides. An entry inherits nothing, so a
/// gear that it does not repeat would be lost without a word.
/// @throws Error (input) if the pattern states a gear ratio other than 1, and the entry, counting in the same
/// way, none; where it counts in another way, or lacks another key of the pattern, that is a warning
void compare_with_patterns(const JointEntry&, std::vector<std::string>& warnings);

/// A gear ratio between 0 and 1 makes the encoder coarser at the joint: usually it is inverted.
void warn_of_gear(const Field& entry, std::vector<std::string>& warnings);

/// Asks whether the `accuracy` of an encoder behind a gear is the gear's, where gears have such accuracies.
/// @param at_joint  the accuracy, at the joint [rad]
void warn_of_accuracy(const Field& entry, double at_joint, double gear_ratio, std::vector<std::string>&);

}  // namespace qerr
