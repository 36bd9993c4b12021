#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/core/parameter.hpp"

namespace qerr {

using EncoderNumbers = std::map<std::string, double>;       ///< checked parameters in SI units, by name
using EncoderChoices = std::map<std::string, std::string>;  ///< checked choices, by name

/// Range within which an encoder's count is absolute: beyond it a recorded count starts again.
enum class AbsoluteRange { none, signal_period, revolution };

/// A row of the list of encoder kinds: one way to state the resolution of an encoder. An encoder of the spec
/// has the key of exactly one kind.
struct EncoderKind {
  std::string_view name;  ///< key that selects the kind
  std::string_view summary;
  std::vector<Parameter> parameters;
  std::string_view example;  ///< of its parameters in a spec
  /// Keys, separated by `|`, that vendors use both for this kind and for another one; refused with the
  /// remedy.
  std::string_view ambiguous_keys = {};
  std::string_view ambiguous_remedy = {};
  /// Counts per revolution of the encoder's shaft, after decoding; null for a kind stated at the joint.
  double (*counts_per_rev)(const EncoderNumbers&, const EncoderChoices&) = nullptr;
  /// Quantization interval at the joint [rad or m]; null for a kind stated at the encoder's shaft.
  double (*resolution_at_joint)(const EncoderNumbers&, const EncoderChoices&) = nullptr;
  /// Counts in one line or signal period; null: 4, as of a quadrature signal.
  double (*counts_per_period)(const EncoderNumbers&, const EncoderChoices&) = nullptr;
  AbsoluteRange absolute_within = AbsoluteRange::none;
  /// How to state the signal period where the kind's own parameters do not determine it; empty where they do.
  std::string_view period_remedy = {};
};

/// All kinds, in the order of `qerr list encoders`.
const std::vector<EncoderKind>& encoder_kinds();

/// @throws std::out_of_range for an unknown name; specs are checked when they are read
const EncoderKind& encoder_kind(std::string_view name);

/// Keys of every kind: gear_ratio, travel_per_rev, rounding, zero, accuracy, limits of the counter.
const std::vector<Parameter>& common_encoder_parameters();

/// Keys of a kind and those of every kind that apply to it: one stated at the joint has no gear.
std::vector<Parameter> encoder_parameters(const EncoderKind&);

}  // namespace qerr
