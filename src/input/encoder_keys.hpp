#pragma once

#include <string>
#include <vector>

#include "input/read_sections.hpp"
#include "qerr/encoder/encoder_kinds.hpp"

namespace qerr {

/// The first kind that is stated at the joint, or at the encoder's shaft: of examples in messages.
const EncoderKind& first_kind(bool at_joint);

/// The keys of all kinds, each once.
std::vector<std::string> encoder_keys();

/// The keys of a kind and all common ones, also those that it has no use for.
std::vector<Parameter> all_keys_of(const EncoderKind&);

/// The kind of an encoder's entry, whose keys all belong to it.
/// @throws Error (input) if the entry is no mapping, states no kind or two, or has a key that is unknown,
/// ambiguous among vendors or of another kind
const EncoderKind& encoder_kind_of(const Field&);

/// @throws Error (input) if the section `encoders` describes one encoder, without the names of joints
void refuse_bare_encoder(const Field&, const Chain&);

}  // namespace qerr
