#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "input/read_sections.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// A spec with values replaced, many times: the robot is read once, and of a variant only the sections that
/// change.
class SpecVariants {
 public:
  /// @param overrides  of the command line: every variant has them, too
  /// @throws Error like `parse_spec`, whose spec is `base`
  SpecVariants(const std::string& text, const std::string& path, const SpecOverrides& overrides = {});

  const Spec& base() const { return base_; }

  /// The spec with further changes, made like those of --set, together with these; its `sweep` and `design`
  /// sections are left out.
  ///
  /// Equals parse_spec with all overrides, but for `sweep` and warnings about it. May be called from several
  /// threads.
  /// @param effects  entries that are added to `effects:`; one of the same type and joint is replaced
  /// @throws Error (input) with the places of the changes and of the spec
  Spec variant(const std::vector<SpecChange>& changes, const std::vector<Node>& effects = {}) const;

 private:
  Node root_;                          // as in the file, without `sweep` and `design`
  std::vector<SpecChange> overrides_;  // of the command line, in its order
  std::vector<std::string> warnings_;  // about them
  std::optional<std::uint64_t> seed_;
  SpecReader reader_;  // has read root_ with the overrides
  Spec base_;
};

/// Adds an entry to `effects:` of a spec's tree; one of the same type and joint is replaced.
void add_effect(Node& root, const Node& effect);

using ReportText = std::function<std::string(const Spec&)>;

/// Warnings of overrides that change nothing of a report: it is compared with that of the spec without them,
/// one by one. An override that repeats the value which holds is not warned of.
/// @param spec    as `parse_spec` returns it with the overrides
/// @param unused  sections of the spec that the command does not use
/// @param report  none: only overrides of unused sections are found
std::vector<std::string> idle_overrides(const Spec& spec, const SpecOverrides&,
                                        const std::vector<std::string_view>& unused,
                                        const ReportText& report = {});

/// Refuses overrides of encoders and of low-passes all of which the section `design` chooses.
/// @pre spec.design
/// @throws Error (input)
void refuse_chosen(const Spec& spec, const SpecOverrides&);

/// Refuses, for a sweep, overrides of keys that it varies.
/// @throws Error (input)
void refuse_varied(const Spec& spec, const SpecOverrides&);

}  // namespace qerr
