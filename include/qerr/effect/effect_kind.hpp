#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/core/parameter.hpp"
#include "qerr/effect/effect.hpp"

namespace qerr {

/// Position of an effect in the signal path from the motion to the log, in the order of the path.
enum class Stage {
  clock,       ///< when the joint is read [s]
  link,        ///< between joint and gear [rad or m]
  gear,        ///< inside the gear [rad or m]
  disc,        ///< scale and disc of the encoder [rad or m on the joint side]
  line,        ///< within one line or signal period [rad or m on the joint side]
  comparator,  ///< just before the position becomes a count [rad or m on the joint side]
  decoder,     ///< on the count [counts]
  log,         ///< on the logged value [rad or m]
  reference,   ///< on the reference sensor [rad or m]
  kinematics   ///< on the robot's geometry; not part of the signal path
};

/// State of a joint at one sample, as far as effects depend on it.
struct Moment {
  std::uint64_t index = 0;      ///< number of the sample
  double time = 0;              ///< instant of the reading; for effects at the encoder its stamp [s]
  double joint = 0;             ///< true joint position [rad or m]
  double effort = 0;            ///< torque or force at the joint [N m or N]
  double temperature_rise = 0;  ///< since the start [K]
  double velocity = 0;          ///< of the joint [rad/s or m/s]; 0 where no effect needs the effort
  double acceleration = 0;      ///< the same [rad/s^2 or m/s^2]
};

/// Maps the signal at the effect's stage to the disturbed signal. May keep a state from sample to sample: use
/// one action per run, with the samples in order.
using Action = std::function<double(double signal, const Moment&)>;

/// Rounding error behind a decoder, where the mean over the encoder's zero is taken off [counts]: its
/// standard deviation is factor / sqrt(12), its largest magnitude at most factor / 2 + excess.
struct CountError {
  double factor = 1, excess = 0;
};

struct LoopReading;
struct RecordSignals;
struct Term;

/// Remedy of an effect that a diagnosis has found.
struct Remedy {
  bool in_controller = false;  ///< a correction of the readings compensates it
  std::string_view text = {};  ///< an imperative: "subtract ..."
};

/// Another effect that may cause the same error in a record.
struct Twin {
  std::string_view other;        ///< its name
  std::string_view record = {};  ///< what to record to distinguish the two; given in the row of either
  /// Whether the fitted effect cannot be distinguished from the other in any record of these signals; null:
  /// the likelihood of the record decides.
  bool (*inseparable)(const Effect&, const RecordSignals&) = nullptr;
};

/// Layout of a look-up table over the position that compensates an effect. The effect's error must be a
/// smooth function of the position alone.
struct TableShape {
  /// Length of a period in the encoder's coordinate [rad or m]; null for a constant or linear error.
  double (*period)(const Effect&, const Encoder&) = nullptr;
  /// Linear interpolation between n points per period errs by at most (pi/n)^2/2 of a sine's amplitude: 0.12
  /// % at 64; effects with harmonics need more points.
  int points_per_period = 64;
  bool linear = false;  ///< proportional to the position, thus different in every revolution
};

/// Effect that scatters the readings about an unchanged mean path; its magnitude is one parameter.
struct Scattering {
  std::string_view parameter;
  bool (*possible)(const RecordSignals&) = nullptr;  ///< whether a record can show it; null: always
  /// Standard deviation of every row per unit of the parameter [rad or m]; null for an effect that displaces
  /// edges.
  Eigen::ArrayXd (*deviation)(const RecordSignals&) = nullptr;
  bool uniform = false;  ///< the deviation is the same at every row
  /// Parameter that displaces every second edge of the counts by a distance [rad or m].
  double (*of_displacement)(double distance, const Encoder&) = nullptr;
};

/// Encoders that can have an effect, by their counts per signal period.
struct EncoderNeed {
  double least = 0, most = std::numeric_limits<double>::infinity();
  std::string_view why = {}, remedy = {};  ///< of the message about an encoder outside the range
  bool period_must_be_given = false;       ///< warn where the spec does not state the period
};

/// An effect that a diagnosis cannot find in a record, and the signal that the record would need.
struct MissingSignal {
  std::string effect, needs;
};

/// A row of the list of effects: a deviation of real robots from the ideal model, with everything that the
/// program knows about it. Other code refers to effects by these properties, never by a name.
///
/// `action` creates the disturbance of one simulation run from the parameters, the encoder and a seed;
/// `share` is the contribution to the bounds. Effects of stage `log` and `reference` act on the file and on
/// the reference sensor and add nothing to the robot's own figures. For `kinematics`, `share` refers to the
/// tip's position.
///
/// A row with `spec_remedy` is a statement that only a diagnosis makes: it has no action, and specs reject
/// it.
struct EffectKind {
  std::string_view name;
  std::string_view summary;
  std::string_view typical = {};  ///< usual size, and its source
  Stage stage = Stage::disc;
  std::vector<Parameter> parameters = {};
  Action (*action)(const Effect&, const Encoder&, std::uint64_t seed) = nullptr;
  /// Empty where the usage lacks `need`; zero where all parameters are zero.
  std::optional<Share> (*share)(const Effect&, const Encoder&, const Usage&) = nullptr;
  Need need = Need::nothing;
  /// Changes the encoder itself, before any action; null for most effects.
  void (*modify_encoder)(Encoder&) = nullptr;
  /// What a decoder makes of the rounding error; null: nothing.
  CountError (*count_error)(const Effect&) = nullptr;
  bool jumps = false;  ///< at single positions, by more than a count
  /// What it makes of a loop that is closed by the reading; null: a bounded error beside the reading.
  void (*in_loop)(const Effect&, const Encoder&, LoopReading&) = nullptr;
  std::optional<EncoderNeed> encoder_need = {};

  // Diagnosis.

  /// Terms whose coefficients are estimable from a record of these signals; null: not found by regression.
  std::vector<Term> (*terms)(const RecordSignals&) = nullptr;
  /// Term of an effect that begins at one time [s], which a scan estimates.
  Term (*step_at)(const RecordSignals&, double time) = nullptr;
  /// Displacements of a joint's origin, of stage `kinematics`: terms without columns.
  std::vector<Term> (*displacements)(const std::string& joint) = nullptr;
  std::optional<Scattering> scattering = {};
  /// Error in every row of a record, if computed from the record's signals instead of `action` [rad or m];
  /// empty: `action` computes it.
  Eigen::ArrayXd (*replay)(const Effect&, const RecordSignals&) = nullptr;
  bool first_in_stage = false;  ///< acts before the other effects of its stage
  std::vector<Twin> twins = {};
  std::string_view record = {};  ///< what to record to distinguish it from any other effect
  std::optional<MissingSignal> (*missing_signal)(const RecordSignals&) = nullptr;
  std::optional<TableShape> table = {};
  Remedy remedy = {};
  bool is_filter = false;             ///< the extended spec states it under `filters:`
  std::string_view spec_remedy = {};  ///< of a statement: what to write into a spec instead

  /// Whether it is zero-mean and independent from sample to sample.
  bool random() const { return scattering && scattering->deviation; }
};

/// "clock", "link", ...
std::string_view stage_name(Stage);

/// Whether the effect changes the controller's estimate, not only the log or the reference.
inline bool acts_on_robot(const EffectKind& kind) {
  return kind.stage != Stage::log && kind.stage != Stage::reference;
}

/// Dimension of a parameter at a joint. Rows state that of revolute joints; for a prismatic joint, compliance
/// is in m/N and thermal drift in m/K.
inline Dimension dimension_at(const Parameter& p, bool prismatic) {
  if (p.coordinate) return prismatic ? dimension::length : dimension::angle;
  if (prismatic && p.dimension == dimension::compliance) return {1, 0, 0, -1, 0};
  if (prismatic && p.dimension == dimension::angle_per_temperature) return {1, 0, 0, 0, -1};
  if (prismatic && p.dimension == dimension::torque) return {0, 0, 0, 1};
  if (prismatic && p.dimension == dimension::angular_speed) return dimension::speed;
  if (prismatic && p.dimension == dimension::angular_acceleration) return {1, 0, -2};
  if (prismatic && p.dimension == dimension::damping) return {-1, 0, 1, 1};
  if (prismatic && p.dimension == dimension::inertia) return {-1, 0, 2, 1};
  return p.dimension;
}

/// All effects that a spec can name, in the order of `qerr list effects`.
const std::vector<EffectKind>& effect_kinds();

/// All effects of `effect_kinds`, followed by the statements that only a diagnosis makes.
const std::vector<EffectKind>& cause_kinds();

/// Row of `cause_kinds`. @returns null for a name that no row has
const EffectKind* find_effect_kind(std::string_view name);

/// Row of `cause_kinds`.
/// @throws std::out_of_range for a name that no row has; specs are checked when they are read
const EffectKind& effect_kind(std::string_view name);

/// What to record to distinguish two effects.
std::string_view record_advice(std::string_view one, std::string_view other);

}  // namespace qerr
