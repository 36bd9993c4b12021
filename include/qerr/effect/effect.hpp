#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/core/parameter.hpp"
#include "qerr/encoder/encoder.hpp"

namespace qerr {

/// One effect of a spec, its values checked and in SI units.
struct Effect {
  std::string type;
  std::string joint;  ///< the independent joint it acts on
  std::map<std::string, double> numbers;
  std::map<std::string, std::string> choices;

  /// Value of a parameter: the given one, else the default of the effect's row, else 0.
  /// @throws std::out_of_range for a name that is neither given nor a parameter of the row
  double number(const std::string& name) const;

  /// The given value of a parameter, else `otherwise`: also for effects whose row has no such parameter.
  double number_or(const std::string& name, double otherwise) const {
    const auto found = numbers.find(name);
    return found == numbers.end() ? otherwise : found->second;
  }
};

/// Where an effect acts on the way from the motion to the file, in the order in which the signal passes.
enum class Stage {
  clock,       ///< when the joint is read [s]
  link,        ///< between joint and gear [rad or m]
  gear,        ///< inside the gear [rad or m]
  disc,        ///< scale and disc of the encoder [rad or m on the joint side]
  line,        ///< within one line or signal period [rad or m on the joint side]
  comparator,  ///< just before the position becomes a count [rad or m on the joint side]
  decoder,     ///< on the count [counts]
  log,         ///< on what is written [rad or m]
  reference,   ///< on the better sensor that is written beside it [rad or m]
  kinematics   ///< on the robot itself; no signal passes here
};

/// What an effect may know of the moment at which it acts.
struct Moment {
  std::uint64_t index = 0;      ///< number of the sample
  double time = 0;              ///< [s]
  double joint = 0;             ///< true joint position [rad or m]
  double effort = 0;            ///< torque or force at the joint [N m or N]
  double temperature_rise = 0;  ///< since the start [K]
};

/// What an effect makes of the signal at its stage. May remember earlier samples: one action serves one run,
/// in order.
using Action = std::function<double(double signal, const Moment&)>;

/// What a quantity does over a motion: its range, its mean and its mean square.
struct Spread {
  double lower = 0, upper = 0, mean = 0, mean_square = 0;
  /// Mean angular frequency of its changes, rms of its derivative over `stray` [rad/s]; empty: not known.
  std::optional<double> rate = {};

  double middle() const { return 0.5 * (lower + upper); }
  double half() const { return 0.5 * (upper - lower); }
  double largest() const { return std::max(std::abs(lower), std::abs(upper)); }
  double rms() const { return std::sqrt(mean_square); }

  /// Root mean square distance from the middle.
  double stray() const { return std::sqrt(std::max(0.0, mean_square + middle() * (middle() - 2 * mean))); }
};

/// How a joint or an encoder's coordinate is used: what effects of position, speed, load and time are
/// multiplied with. Empty: not known.
struct Usage {
  std::optional<Spread> position;     ///< from the joint's zero [rad or m]
  std::optional<Spread> velocity;     ///< [rad/s or m/s]
  std::optional<Spread> effort;       ///< [N m or N]
  std::optional<Spread> temperature;  ///< rise since the start [K]
  std::optional<double> duration;     ///< [s]
  std::optional<double> reversals;    ///< pi times the turns per second, a mean angular frequency [rad/s]
  std::vector<double> speeds;  ///< velocities that occur equally often; empty: not known [rad/s or m/s]
};

/// What a share needs to know of the usage.
enum class Need { nothing, position, velocity, effort, temperature, duration };

/// How an error comes and goes, which decides what of it a filter lets through.
enum class Course {
  constant,   ///< not within the filter's memory
  motion,     ///< as the quantity it is proportional to, a sine of that one's mean angular frequency
  reversals,  ///< changes sign when the motion turns
  travel,     ///< periodic in the position
  white       ///< anew at every sample
};

/// A sine in an error that is periodic in the position.
struct Wave {
  double number = 0;  ///< its phase per joint coordinate [rad/rad or rad/m]
  double part = 0;    ///< of the error's variance
};

/// What an effect adds to the error of its coordinate, estimate - true [rad or m].
///
/// The worst case grows by |mean| + half_width, the variance by sigma^2 (about the mean). A Gaussian has no
/// worst case; its half_width is four sigma.
struct Share {
  double mean = 0, half_width = 0, sigma = 0;
  Course course = Course::constant;
  std::vector<Wave> waves = {};     ///< of `travel`; what their parts leave of 1 counts as white
  std::optional<double> rate = {};  ///< of `motion` [rad/s]; empty: not known
};

struct RecordSignals;
struct Term;

/// What can be done about an effect that a diagnosis has found.
struct Remedy {
  bool in_controller = false;  ///< a correction of the readings compensates it
  std::string_view text = {};  ///< without its subject
};

/// Another effect that may make the same error in a record.
struct Twin {
  std::string_view other;        ///< its name
  std::string_view record = {};  ///< what to record to distinguish the two; may stand in the row of either
  /// Whether the fitted effect cannot be distinguished from the other in any record of these signals; null:
  /// the likelihood of the record decides.
  bool (*inseparable)(const Effect&, const RecordSignals&) = nullptr;
};

/// How a look-up table over the position holds an effect whose error depends on the position alone and is
/// smooth in it.
struct TableShape {
  /// Length of a period in the encoder's coordinate [rad or m]; null for what is constant or linear.
  double (*period)(const Effect&, const Encoder&) = nullptr;
  /// Linear interpolation between 64 points misses a sine by 0.12 % of its amplitude; effects with harmonics
  /// need more.
  int points_per_period = 64;
  bool linear = false;  ///< grows with the position, and is another one in every revolution
};

/// How an effect scatters readings without moving their mean path, by its one number.
struct Scattering {
  std::string_view parameter;
  bool (*possible)(const RecordSignals&) = nullptr;  ///< in such a record; null: in every one
  /// Standard deviation of every row per unit of the parameter [rad or m]; null: it displaces edges instead.
  Eigen::ArrayXd (*deviation)(const RecordSignals&) = nullptr;
  bool uniform = false;  ///< the deviation is the same at every row
  /// Parameter that displaces every second edge of the counts by a distance [rad or m].
  double (*of_displacement)(double distance, const Encoder&) = nullptr;
};

/// Encoders that an effect is possible with, by their counts per signal period.
struct EncoderNeed {
  double least = 0, most = std::numeric_limits<double>::infinity();
  std::string_view why = {}, remedy = {};  ///< of an encoder with another number
  bool period_must_be_given = false;       ///< warn where the spec does not state the period
};

/// What a record lacks for a diagnosis to find an effect.
struct Lack {
  std::string effect, needs;
};

/// A row of the list of effects: what a real robot adds to the ideal model, and all that the program knows of
/// it. Other code refers to effects by these properties, never by a name.
///
/// `action` makes it for one run of a simulation from its parameters, the encoder it acts on and a seed;
/// `share` is what it adds to the bounds. Effects of stage `log` and `reference` act on the file and on the
/// reference sensor and add nothing to the robot's own figures. For `kinematics`, `share` refers to the tip's
/// position.
///
/// A row with `spec_remedy` is a statement that only a diagnosis makes: it has no action, and specs refuse
/// it.
struct EffectKind {
  std::string_view name;
  std::string_view summary;
  std::string_view typical = {};  ///< usual size, and its source
  Stage stage = Stage::disc;
  std::vector<Parameter> parameters = {};
  Action (*action)(const Effect&, const Encoder&, std::uint64_t seed) = nullptr;
  /// Empty where the usage lacks what the row needs. With all parameters zero it is zero in any case.
  std::optional<Share> (*share)(const Effect&, const Encoder&, const Usage&) = nullptr;
  Need need = Need::nothing;
  /// What it changes in the encoder itself, before any action; null for most.
  void (*rebuilt)(Encoder&) = nullptr;
  std::optional<EncoderNeed> encoder_need = {};

  // Diagnosis.

  /// Terms whose coefficients a record of these signals can show; null: not found by regression.
  std::vector<Term> (*terms)(const RecordSignals&) = nullptr;
  /// The term of an effect that begins at one moment, which a scan finds [s].
  Term (*step_at)(const RecordSignals&, double time) = nullptr;
  /// Displacements of a joint's origin, of stage `kinematics`: terms without columns.
  std::vector<Term> (*displacements)(const std::string& joint) = nullptr;
  std::optional<Scattering> scattering = {};
  /// What it adds over a record, where the record's signals replace the action [rad or m].
  Eigen::ArrayXd (*replay)(const Effect&, const RecordSignals&) = nullptr;
  bool before_teeth = false;  ///< acts before other effects of its stage
  std::vector<Twin> twins = {};
  std::string_view record = {};  ///< what to record to distinguish it from any other effect
  std::optional<Lack> (*lack)(const RecordSignals&) = nullptr;
  std::optional<TableShape> table = {};
  Remedy remedy = {};
  bool is_filter = false;             ///< the extended spec states it under `filters:`
  std::string_view spec_remedy = {};  ///< of a statement: what to do with it in a spec

  /// Whether it is independent from sample to sample, without a mean.
  bool random() const { return scattering && scattering->deviation; }
};

/// The name of a stage as people say it: "clock", ...
std::string_view stage_name(Stage);

/// Whether the effect changes what the controller believes of the robot, not only a file or a reference.
inline bool acts_on_robot(const EffectKind& kind) {
  return kind.stage != Stage::log && kind.stage != Stage::reference;
}

/// The dimension that a parameter has at a joint: rows are written for revolute ones, and a prismatic one
/// yields in m/N and drifts in m/K.
inline Dimension dimension_at(const Parameter& p, bool prismatic) {
  if (p.coordinate) return prismatic ? dimension::length : dimension::angle;
  if (prismatic && p.dimension == dimension::compliance) return {1, 0, 0, -1, 0};
  if (prismatic && p.dimension == dimension::angle_per_temperature) return {1, 0, 0, 0, -1};
  return p.dimension;
}

/// Phase of a periodic effect's sine per joint coordinate: its order times the turns of the shaft that the
/// order counts, of the encoder unless it says `joint`; signed, as the shaft turns [rad/rad or rad/m].
/// @returns 0 for an effect without an order
double wave_number(const Effect&, const Encoder&);

/// Unit vector along which an effect of stage `kinematics` displaces its joint's origin, by its choice `axis`
/// in the axes of the joint's parent link.
/// @throws std::out_of_range for an effect without that choice
Eigen::Vector3d displacement_direction(const Effect&);

/// All effects that a spec can name, in the order of `qerr list effects`.
const std::vector<EffectKind>& effect_kinds();

/// These, and after them the statements that only a diagnosis makes.
const std::vector<EffectKind>& cause_kinds();

/// Row of `cause_kinds`. @returns null for a name that no row has
const EffectKind* find_effect_kind(std::string_view name);

/// Row of `cause_kinds`.
/// @throws std::out_of_range for a name that no row has; specs are checked when they are read
const EffectKind& effect_kind(std::string_view name);

/// Whether any number of an effect is not zero.
bool has_size(const Effect&);

/// What to record to distinguish two effects.
std::string_view record_advice(std::string_view one, std::string_view other);

}  // namespace qerr
