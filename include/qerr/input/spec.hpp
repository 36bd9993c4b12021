#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/design/requirement.hpp"
#include "qerr/effect/effect.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/filter/norms.hpp"
#include "qerr/kinematics/configurations.hpp"
#include "qerr/kinematics/robot_model.hpp"
#include "qerr/simulate/simulate.hpp"

namespace qerr {

/// A filter of the spec, designed, with its norms.
struct NamedFilter {
  std::string name;
  Filter filter;
  Norms norms;
  std::shared_ptr<const FamilyDesign> designed = {};  ///< null: given by coefficients, or a pure difference
  std::vector<std::size_t> joints =
      {};                   ///< independent joints whose coordinates it passes; empty: any signal
  bool controller = false;  ///< F of the only joint's controller: its output is a torque
};

/// Whether the filter passes the signal: the coordinate of one of its joints, or, if it has none, any that is
/// no loop's.
bool is_filtered(const NamedFilter&, const Signal&);

/// Properties of one encoder that the bounds do not need.
struct EncoderFigures {
  std::string kind;                      ///< key of the encoder kind
  double counts_per_rev = 0;             ///< after decoding; of `resolution` at a revolute joint 2 pi/Delta
  double gear_ratio = 1;                 ///< with its sign
  std::optional<double> max_count_rate;  ///< that the encoder, or the counter's input, can follow [counts/s]
  std::optional<int> counter_bits;       ///< of the counter whose differences the filters take
};

/// One step of an axis of a sweep: changes of the spec that are made together.
struct SweepStep {
  std::vector<std::string> names;                            ///< in reports, one for each key of the axis
  std::vector<std::pair<std::string, std::string>> changes;  ///< dotted path, YAML text
  std::vector<std::string> effects;                          ///< YAML texts of entries to add to `effects`
};

/// One axis of `sweep:`: dotted paths, and the values that they take together. Axes cross: the first one
/// varies slowest.
struct SweepAxis {
  std::vector<std::string> keys;
  std::vector<SweepStep> steps;
};

/// What becomes of a row of a log in which a signal has no value: an error, or the row is left out, or the
/// last value of the signal is held.
enum class MissingValues { error, drop, hold };

/// The column of a log's file that has a signal.
struct LogSource {
  std::string signal;  ///< `time`, `a1.counts`, `tip.x`
  std::string column;  ///< its header, with or without its unit; `column 3` of a file without a header
  std::string unit;    ///< in place of that of the header; "" without one
};

/// How a log is read.
struct LogReading {
  MissingValues missing = MissingValues::error;
  std::vector<LogSource> columns;  ///< those that are not called as their signals
};

struct DesignRequest;  // src/input/design_request.hpp

/// A spec, read and checked: everything in SI units, every name resolved.
struct Spec {
  std::string file;
  std::string text;                                            ///< of the file
  std::string sha256;                                          ///< of the file's bytes
  std::vector<std::pair<std::string, std::string>> overrides;  ///< --set KEY=VALUE, in order
  std::string robot_name;
  std::string points_file;  ///< of `method: file`, "" otherwise
  OperationalModel model;
  std::vector<EncoderFigures> encoder_figures;  ///< one per independent joint
  std::vector<NamedFilter> filters;             ///< in the spec's order
  std::vector<EstimatorDesign> estimators;
  Configurations configurations;
  std::vector<Requirement> requirements;
  std::optional<double> threshold_length;  ///< [m]
  std::optional<Motion> motion;
  std::vector<Effect> effects;
  LogReading log;
  std::vector<SweepAxis> sweep;
  std::shared_ptr<const DesignRequest> design;  ///< null without a section `design`
  std::vector<std::string> warnings;
};

/// The filters of a spec and their norms, in its order.
std::vector<Filter> designed_filters(const Spec&);
std::vector<Norms> filter_norms(const Spec&);

/// Changes of a spec by the command line, made before it is checked.
struct SpecOverrides {
  std::vector<std::pair<std::string, std::string>> values;  ///< dotted path, YAML text
  std::optional<std::uint64_t> seed;
};

/// Reads a spec and its URDF. `-` reads the spec from standard input, with paths relative to the working
/// folder.
/// @throws Error (input) with all faults; (file_system) if a file cannot be read
Spec read_spec(const std::string& path, const SpecOverrides& = {});

/// Reads the text of a spec as if it were the file at `path`, to which its own paths are relative.
/// @throws Error like read_spec
Spec parse_spec(const std::string& text, const std::string& path, const SpecOverrides& = {});

/// An effect to be written into a spec, with a note for the reader.
struct AddedEffect {
  Effect effect;
  std::string note;  ///< written above it as a comment; may have several lines
};

/// A velocity estimator to be written into a spec's `filters:`. A present entry of this name gets a new
/// low-pass; otherwise a new entry has the derivative and sample rate of the spec's velocity filter.
struct AddedFilter {
  std::string name;
  std::string family;  ///< of the low-pass
  int order = 0;
  double cutoff = 0;  ///< [Hz]
  std::string note;   ///< written as a comment
};

/// The text of a spec with effects appended to its `effects:`, for a file at `target`.
///
/// The user's text, comments and layout are kept. The spec's overrides (`--set`) are written into the text.
/// Paths of other files (URDF, motion, configurations) are rewritten relative to the folder of `target`.
/// Effects without a row in the list of effects, and effects or filters that the reader rejects, become
/// comments at the end with the reason.
/// @param remarks  a comment above the first effect, or at the end of a spec without effects
/// @param target  path of the new file; `-` means the working folder
/// @throws Error (input) if an override cannot be written into the layout of the text
std::string extended_spec(const Spec&, const std::vector<AddedEffect>&, const std::string& remarks,
                          const std::string& target, const std::vector<AddedFilter>& filters = {});

}  // namespace qerr
