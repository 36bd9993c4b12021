#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/core/parameter.hpp"

namespace qerr {

/// A way to state an encoder's counts per revolution. Exactly one kind's key stands in an encoder of the
/// spec.
struct EncoderKind {
  std::string_view name;  ///< the key that tells the kind
  std::string_view summary;
  std::vector<Parameter> parameters;
  /// Counts per revolution of the encoder's shaft, after decoding; for `resolution`, which is at the joint,
  /// empty.
  double (*counts_per_rev)(const std::map<std::string, double>& numbers,
                           const std::map<std::string, std::string>& choices);
  /// Counts in one line or signal period; 4, of a quadrature signal, where nothing else is said.
  double (*counts_per_period)(const std::map<std::string, double>& numbers,
                              const std::map<std::string, std::string>& choices) = nullptr;
};

/// All kinds, in the order of `qerr list encoders`.
const std::vector<EncoderKind>& encoder_kinds();

/// Keys that go with every kind: gear_ratio, travel_per_rev, rounding, zero.
const std::vector<Parameter>& common_encoder_parameters();

}  // namespace qerr
