#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/lists.hpp"
#include "core/solve.hpp"
#include "core/text.hpp"
#include "input/csv.hpp"
#include "input/joint_entries.hpp"
#include "input/object_reader.hpp"
#include "qerr/core/parameter.hpp"
#include "qerr/encoder/encoder.hpp"

namespace qerr {

namespace {

/// The keys of a kind and all common ones, also those that it has no use for.
std::vector<Parameter> all_keys_of(const EncoderKind& kind) {
  std::vector<Parameter> rows = kind.parameters;
  for (const Parameter& p : common_encoder_parameters()) rows.push_back(p);
  return rows;
}

/// Some vendors count lines in `cpr` and `ppr`, others counts: a factor of 4.
void refuse_ambiguous_keys(const Field& f) {
  for (const auto& [key, value] : read_map(f))
    for (const EncoderKind& kind : encoder_kinds())
      for (const std::string& ambiguous : words_of(kind.ambiguous_keys))
        if (key.name == ambiguous)
          throw Error(
              key.place, value.path,
              "'" + key.name + "' is ambiguous: vendors use it for lines and for counts, 4 times as many",
              "'" + key.name + "'", std::string(kind.ambiguous_remedy));
}

/// @throws Error (input) for keys that no encoder has, and for those that the kind does not have
void check_keys(const Field& f, const EncoderKind* kind) {
  const std::vector<std::string> known = encoder_keys();
  std::vector<Fault> faults;
  for (const Node::Entry& entry : f.node->entries) {
    const std::string& key = entry.key.name;
    if (!contains(known, key))
      add_unknown_key(f, entry, known, faults);
    else if (kind && !has_row(all_keys_of(*kind), key))
      faults.push_back({entry.key.place, f.path_of(key),
                        "does not belong to an encoder that is stated by " + std::string(kind->name),
                        quoted(key), "remove it, or state the encoder in the other way"});
  }
  if (!faults.empty()) throw Error(faults);
}

/// `resolution: 17 bits` is another kind, `bits: 17`.
void refuse_kind_as_unit(const Field& f, const EncoderKind& kind) {
  const std::string& text = f.node->find(kind.name)->text;
  const std::size_t at = text.find_first_not_of("0123456789. ");
  if (at == std::string::npos || at == 0) return;
  const std::string unit = text.substr(at), number = text.substr(0, text.find_last_not_of(' ', at - 1) + 1);
  for (const EncoderKind& other : encoder_kinds())
    if (&other != &kind && (unit == other.name || unit + 's' == other.name))
      throw Error(f.node->find(kind.name)->place, f.path_of(kind.name), "has the wrong kind of unit",
                  quoted(text), "write " + std::string(other.name) + ": " + number);
}

/// The kind whose key the entry has; null if it has none.
const EncoderKind* stated_kind(const Node& entry) {
  for (const EncoderKind& kind : encoder_kinds())
    if (entry.find(kind.name)) return &kind;
  return nullptr;
}

const EncoderKind& stated_kind(const Field& f) {
  const EncoderKind* found = nullptr;
  for (const EncoderKind& kind : encoder_kinds()) {
    if (!f.node->find(kind.name)) continue;
    if (found)
      throw Error(f.node->place, f.path, "an encoder must be stated in one way",
                  "'" + std::string(found->name) + "' and '" + std::string(kind.name) + "'",
                  "keep one of them");
    found = &kind;
  }
  check_keys(f, found);
  if (found) return *found;
  throw Error(f.node->place, f.path, "the encoder's counts are missing", described(*f.node),
              "give one of " + did_you_mean("", names_of(encoder_kinds())).substr(7));
}

/// @throws Error (input) if the section `encoders` describes one encoder, without the names of joints
void refuse_bare_encoder(const Field& f, const Chain& chain) {
  const std::vector<std::string> keys = encoder_keys(), joints = joint_names(chain);
  if (f.node->type != Node::Type::mapping) return;
  for (const Node::Entry& entry : f.node->entries)
    if (contains(keys, entry.key.name) && !contains(joints, entry.key.name))
      throw Error(entry.key.place, f.path_of(entry.key.name), "this is a key of an encoder, not a joint",
                  quoted(entry.key.name),
                  "name the joints: '*': {" + std::string(first_kind(false).example) + "} for all");
}

/// Whether the value says something else than the default of the row.
bool unusual(const Node& value, const Parameter& row) {
  if (row.kind == Kind::choice) return value.text != choices_of(row).front();
  std::string why;
  const auto quantity = parse_quantity(value.text, why);
  return quantity && quantity->value != row.fallback.value_or(0);
}

std::string default_of(const Parameter& row) {
  if (row.kind == Kind::choice) return choices_of(row).front() + " holds";
  return row.fallback ? shortest(*row.fallback) + " holds" : "none is assumed";
}

/// The keys of the pattern that the entry could state, too, does not, and would have another value without.
std::vector<Parameter> not_repeated(const Node& entry, const Node& pattern, const EncoderKind& kind) {
  std::vector<Parameter> rows;
  for (const Parameter& row : encoder_parameters(kind)) {
    const Node* value = pattern.find(row.name);
    if (!row.required && value && !entry.find(row.name) && unusual(*value, row)) rows.push_back(row);
  }
  return rows;
}

void compare(const Field& own, const Field& pattern, std::vector<std::string>& warnings) {
  const EncoderKind* kind = stated_kind(*own.node);
  const EncoderKind* other = stated_kind(*pattern.node);
  if (!kind || !other) return;  // faulty, or read elsewhere
  for (const Parameter& row : not_repeated(*own.node, *pattern.node, *kind)) {
    if (row.name == "travel_per_rev") continue;  // a prismatic joint requires it
    const std::string name(row.name), value = pattern.node->find(row.name)->text;
    const bool same_gear = row.name == "gear_ratio" && kind == other;
    if (same_gear)
      throw Error(own.node->place, own.path,
                  "the entry states no gear_ratio, but " + pattern.path +
                      ", which it replaces wholly, has gear_ratio: " + value,
                  described(*own.node),
                  "add gear_ratio: " + value + ", or gear_ratio: 1 for an encoder at the joint");
    warnings.push_back(own.path + " states no " + name + ": " + default_of(row) + ", where " + pattern.path +
                       ", which it replaces wholly, has " + name + ": " + value + "; write " + name +
                       " to say which is meant");
  }
}

/// Compares a joint's own encoder entry with the patterns that it overrides. An entry inherits nothing, so a
/// gear that it does not repeat would be lost without a word.
/// @throws Error (input) if the pattern states a gear ratio other than 1, and the entry, counting in the same
/// way, none; where it counts in another way, or lacks another key of the pattern, that is a warning
void compare_with_patterns(const JointEntry& entry, std::vector<std::string>& warnings) {
  if (!entry.own.node) return;
  for (const Field& pattern : entry.patterns)
    if (pattern.node->type == Node::Type::mapping) compare(entry.own, pattern, warnings);
}

/// Asks about counts of `4.096`, which elsewhere are thousands.
void warn_of_thousands(const Field& entry, std::vector<std::string>& warnings) {
  for (const Parameter& row : encoder_kind_of(entry).parameters) {
    const Node* const node = row.coordinate ? nullptr : entry.node->find(row.name);
    const auto value = node ? parse_number(node->text) : std::nullopt;
    if (value && *value != std::floor(*value) && may_be_thousands(node->text))
      add_once(warnings, entry.path_of(row.name) + ": " + node->text +
                             " has a decimal point; if it is one of thousands, leave it out");
  }
}

/// A gear ratio between 0 and 1 makes the encoder coarser at the joint: usually it is inverted.
void warn_of_gear(const Field& entry, std::vector<std::string>& warnings) {
  const Node* ratio = entry.node->find("gear_ratio");
  std::string why;
  const auto value = ratio ? parse_quantity(ratio->text, why) : std::nullopt;
  if (!value || std::abs(value->value) >= 1) return;
  const std::string text = entry.path + ".gear_ratio: " + ratio->text +
                           " makes the encoder coarser at the joint: it is encoder revolutions per joint "
                           "revolution; is it inverted? Write " +
                           significant(1 / value->value, 4) + " if the joint is the slow side";
  add_once(warnings, text);
}

/// Asks whether the `accuracy` of an encoder behind a gear is the gear's, where gears have such accuracies.
/// @param at_joint  the accuracy, at the joint [rad]
void warn_of_accuracy(const Field& entry, double at_joint, double gear_ratio,
                      std::vector<std::string>& warnings) {
  // The best gears are stated with 0.5 arcmin (strain wave), which discs have as well.
  constexpr double best_gear = 0.5 / 60 * std::numbers::pi / 180;
  const double ratio = std::abs(gear_ratio);
  if (!(ratio > 1) || !(at_joint * ratio >= best_gear * (1 - 1e-12)) || entry.node->find("gear_accuracy"))
    return;
  const std::string text =
      entry.path + ".accuracy: " + entry.node->find("accuracy")->text +
      " is taken as an angle of the encoder's shaft, 1/" + significant(ratio, 6) +
      " of it at the joint; is it the gear's? Then write gear_accuracy, which is at the joint, in its place; "
      "else state that of the gear beside it, or 0";
  add_once(warnings, text);
}

constexpr double most_ratio = 1e6;  ///< of a coupling: joint angle per encoder angle after the gear

void refuse_key(const Object& o, std::string_view key, const std::string& why, const std::string& remedy) {
  if (o.has(key)) o.at(key).refuse(why, remedy);
}

std::string own_entry_of_prismatic(const IndependentJoint& joint) {
  return "write '" + joint.name + ": {" + std::string(first_kind(false).example) +
         ", travel_per_rev: 10 mm}' (screw lead or pulley travel), or '" + joint.name + ": {" +
         std::string(first_kind(true).example) + "}'";
}

/// Joint travel per encoder-shaft revolution before the gear: 2 pi, or the travel of screw or pulley.
/// @param shared  the entry holds for prismatic joints, too, whose travel it may state
double travel_of(const Object& o, const IndependentJoint& joint, bool shared) {
  if (!joint.prismatic()) {
    if (!shared)
      refuse_key(o, "travel_per_rev", "a revolute joint has no travel per revolution",
                 "remove travel_per_rev");
    return 2 * std::numbers::pi;
  }
  if (const auto travel = o.number("travel_per_rev")) return *travel;
  throw Error(o.self().node->place, o.self().path,
              "joint '" + joint.name + "' is prismatic and needs its travel per revolution",
              described(*o.self().node), own_entry_of_prismatic(joint));
}

/// The bound of `accuracy` in joint coordinates. An angle is one of the encoder's shaft, where there is one;
/// a length is at the prismatic joint.
double accuracy_at_joint(const Object& o, const IndependentJoint& joint, const std::optional<double>& ratio) {
  if (!o.has("accuracy")) return 0;
  const Field f = o.at("accuracy");
  std::string why;
  const auto written = f.node->type == Node::Type::scalar ? parse_quantity(f.node->text, why) : std::nullopt;
  const bool of_shaft = ratio && (!joint.prismatic() || (written && written->dimension == dimension::angle));
  const double bound = *o.number("accuracy", of_shaft ? dimension::angle : coordinate_dimension(joint));
  constexpr double half_turn = std::numbers::pi;
  if ((of_shaft || !joint.prismatic()) && bound > half_turn)
    f.refuse("is more than half a revolution",
             "without a unit it is in rad: give the unit, such as 20 arcsec");
  return of_shaft ? bound / std::abs(*ratio) : bound;
}

/// How fast the encoder and its counter can follow.
void read_counter_limits(const Object& o, const Encoder& encoder, EncoderFigures& figures) {
  if (o.has("max_frequency") && o.has("max_count_rate"))
    o.at("max_count_rate").refuse("is stated a second time, by max_frequency", "keep one of the two");
  figures.max_count_rate = o.number("max_count_rate");
  if (const auto frequency = o.number("max_frequency"))
    figures.max_count_rate = encoder.counts_per_period * *frequency;
  if (const auto bits = o.number("counter_bits")) figures.counter_bits = static_cast<int>(*bits);
}

std::pair<Encoder, EncoderFigures> read_encoder(const Field& f, const IndependentJoint& joint, bool shared) {
  const EncoderKind& kind = encoder_kind_of(f);
  const Object o(f, all_keys_of(kind));
  const auto numbers = o.numbers(kind.parameters, coordinate_dimension(joint));
  Encoder encoder;
  encoder.rounding = o.choice("rounding") == "down" ? Rounding::down : Rounding::nearest;
  encoder.zero_known = o.choice("zero") == "known";
  EncoderFigures figures{std::string(kind.name), 0, 1, {}, {}};
  if (kind.counts_per_rev) {
    figures.counts_per_rev = kind.counts_per_rev(numbers, o.choices(kind.parameters));
    figures.gear_ratio = o.number("gear_ratio").value();
    const double travel = travel_of(o, joint, shared);
    encoder.resolution = travel / (figures.counts_per_rev * std::abs(figures.gear_ratio));
    encoder.shaft_ratio = 2 * std::numbers::pi * figures.gear_ratio / travel;
    encoder.accuracy = accuracy_at_joint(o, joint, encoder.shaft_ratio);
    encoder.gear_accuracy = o.number("gear_accuracy", coordinate_dimension(joint)).value_or(0);
    if (kind.counts_per_period)
      encoder.counts_per_period = kind.counts_per_period(numbers, o.choices(kind.parameters));
  } else {
    refuse_key(o, "gear_ratio", "a resolution at the joint has no gear ratio", "remove gear_ratio");
    refuse_key(o, "travel_per_rev", "a resolution at the joint has no travel per revolution",
               "remove travel_per_rev");
    refuse_key(o, "gear_accuracy", "an encoder at the joint has no gear", "remove gear_accuracy");
    encoder.resolution = kind.resolution_at_joint(numbers, o.choices(kind.parameters));
    encoder.accuracy = accuracy_at_joint(o, joint, std::nullopt);
    figures.counts_per_rev = 2 * std::numbers::pi / encoder.resolution;
  }
  read_counter_limits(o, encoder, figures);
  const Dimension dimension = coordinate_dimension(joint);
  const PhysicalRange possible = physical_range(dimension);
  if (!(encoder.resolution >= possible.smallest && encoder.resolution <= possible.largest))
    throw Error(f.node->place, f.path,
                "the resolution at the joint must be from " + shortest(possible.smallest) + " to " +
                    shortest(possible.largest) + ' ' + unit_name(dimension),
                shortest(encoder.resolution), "check counts and gear ratio");
  if (!joint.prismatic() && encoder.resolution > 2 * std::numbers::pi)
    throw Error(f.node->place, f.path, "the encoder has less than one count per joint revolution",
                shortest(encoder.resolution) + " rad a count",
                !kind.counts_per_rev
                    ? "without a unit it is in rad: give the unit, such as 20 arcsec"
                    : "gear_ratio is encoder revolutions per joint revolution: is it inverted?");
  return {encoder, figures};
}

/// Whether a joint's own entry repeats the travel of a pattern, of which it may be a copy with a change.
bool repeats_travel(const JointEntry& entry) {
  const Node* own = entry.own.node ? entry.own.node->find("travel_per_rev") : nullptr;
  return own && std::ranges::any_of(entry.patterns, [&](const Field& pattern) {
           const Node* travel = pattern.node->find("travel_per_rev");
           return travel && travel->text == own->text;
         });
}

/// Whether one of the joints of this entry is prismatic: its travel_per_rev is then that joint's.
bool holds_for_prismatic(const std::vector<JointEntry>& entries, const Chain& chain, const Field& entry) {
  for (std::size_t i = 0; i < entries.size(); ++i)
    if (entries[i].given() && entries[i].holding().node == entry.node && chain.independent[i].prismatic())
      return true;
  return false;
}

/// One fault for the revolute joints without an encoder, and one for each prismatic one, which needs an entry
/// of its own.
void refuse_missing(const Field& f, const Chain& chain, const std::vector<std::size_t>& missing) {
  std::vector<Fault> faults;
  std::vector<std::string> revolute;
  for (const std::size_t i : missing) {
    const IndependentJoint& joint = chain.independent[i];
    if (joint.prismatic())
      faults.push_back({f.node->place, f.path_of(joint.name), "the prismatic joint has no encoder", "",
                        own_entry_of_prismatic(joint)});
    else
      revolute.push_back(joint.name);
  }
  if (!revolute.empty()) {
    const bool one = revolute.size() == 1;
    faults.push_back({f.node->place, one ? f.path_of(revolute.front()) : f.path,
                      one ? "the joint has no encoder" : "joints have no encoder",
                      one ? "" : list_of_names(revolute),
                      "add '" + revolute.front() + ": {" + std::string(first_kind(false).example) +
                          "}', or '*' in quotation marks for all other joints"});
  }
  if (!faults.empty()) throw Error(faults);
}

/// Joints that the coupling moves by several encoders, though their own one is stated as if at the joint.
void warn_of_joint_side(const Field& f, Spec& spec) {
  const Transmission& t = spec.model.transmission;
  const auto n = std::ssize(t.encoders);
  std::vector<std::string> names;
  for (Eigen::Index i = 0; i < n; ++i) {
    const EncoderFigures& figures = spec.encoder_figures[i];
    if (figures.kind.empty()) continue;  // of a faulty entry
    const EncoderKind& kind = encoder_kind(figures.kind);
    const bool at_joint = kind.resolution_at_joint || (kind.absolute_within == AbsoluteRange::revolution &&
                                                       std::abs(figures.gear_ratio) == 1);
    if (at_joint && t.coupling.row(i) != Eigen::MatrixXd::Identity(n, n).row(i))
      names.push_back(spec.model.chain.independent[i].name);
  }
  if (!names.empty())
    spec.warnings.push_back(f.path + " multiplies the encoders of " + list_of_names(names) +
                            ", too, which are stated as if they were at the joint (no gear_ratio): where an "
                            "encoder is at the joint, "
                            "give the joint a row of the identity; where it is at a motor, this is right");
}

}  // namespace

const EncoderKind& first_kind(bool at_joint) {
  const auto& kinds = encoder_kinds();
  return *std::ranges::find_if(
      kinds, [&](const EncoderKind& kind) { return (kind.resolution_at_joint != nullptr) == at_joint; });
}

std::vector<std::string> encoder_keys() {
  std::vector<std::string> keys;
  for (const EncoderKind& kind : encoder_kinds())
    for (const Parameter& row : encoder_parameters(kind)) add_once(keys, std::string(row.name));
  return keys;
}

bool is_encoder_key(const std::string& key) { return contains(encoder_keys(), key); }

const EncoderKind& encoder_kind_of(const Field& f) {
  if (f.node->type != Node::Type::mapping)
    f.refuse("must be a mapping", "write {" + std::string(first_kind(false).example) + "}");
  refuse_ambiguous_keys(f);
  const EncoderKind& kind = stated_kind(f);
  refuse_kind_as_unit(f, kind);
  return kind;
}

void read_encoders(const Field& f, const RobotModel& robot, Spec& spec, Faults& faults) {
  const Chain& chain = spec.model.chain;
  Transmission& transmission = spec.model.transmission;
  const std::size_t n = chain.independent.size();
  transmission.encoders.resize(n);
  transmission.coupling = Coupling::identity(n);
  spec.encoder_figures.resize(n);
  refuse_bare_encoder(f, chain);
  const std::vector<JointEntry> entries = joint_entries(f, robot, spec, faults);
  const bool complete = !faults.any();  // a misspelt name leaves its joint without an entry
  EntryFaults of_entries;
  std::vector<std::size_t> missing;
  for (std::size_t i = 0; i < n; ++i) {
    const IndependentJoint& joint = chain.independent[i];
    if (!entries[i].given()) {
      missing.push_back(i);
      continue;
    }
    const Field& entry = entries[i].holding();
    of_entries.guard(joint, entry, [&] {
      std::tie(transmission.encoders[i], spec.encoder_figures[i]) = read_encoder(
          entry, joint, holds_for_prismatic(entries, chain, entry) || repeats_travel(entries[i]));
      compare_with_patterns(entries[i], spec.warnings);
      warn_of_gear(entry, spec.warnings);
      warn_of_thousands(entry, spec.warnings);
      if (!joint.prismatic())
        warn_of_accuracy(entry, transmission.encoders[i].accuracy, spec.encoder_figures[i].gear_ratio,
                         spec.warnings);
      warn_of_bare_numbers(entry, common_encoder_parameters(), coordinate_dimension(joint), spec.warnings);
    });
  }
  faults.guard([&] { of_entries.raise(); });
  if (complete) faults.guard([&] { refuse_missing(f, chain, missing); });
}

void read_coupling(const Field& f, Spec& spec) {
  const auto n = spec.model.chain.independent.size();
  const std::string shape =
      "give " + std::to_string(n) + " rows of " + std::to_string(n) + " numbers, one a joint in chain order";
  const std::vector<Field> rows = read_list(f, "[[1, 0], [0, 1]]");
  if (rows.size() != n) f.refuse("the coupling has the wrong size", shape);
  Eigen::MatrixXd coupling(n, n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::vector<Field> row = read_list(rows[i]);
    if (row.size() != n) rows[i].refuse("the coupling has the wrong size", shape);
    for (std::size_t j = 0; j < n; ++j)
      coupling(i, j) = read_number(row[j], {.name = "coupling", .least = -most_ratio, .most = most_ratio});
  }
  if (!coupling.allFinite() || rank(coupling) < static_cast<Eigen::Index>(n))
    throw Error(f.node->place, f.path, "the coupling is singular: a joint motion moves no encoder",
                "rank " + std::to_string(rank(coupling)) + " of " + std::to_string(n), "check its rows");
  spec.model.transmission.coupling = coupling;
  if (spec.encoder_figures.size() == n) warn_of_joint_side(f, spec);
}

}  // namespace qerr
