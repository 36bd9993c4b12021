#include "input/encoder_keys.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/suggest.hpp"
#include "core/text.hpp"
#include "input/joint_entries.hpp"
#include "input/unknown_key.hpp"
#include "qerr/encoder/encoder_kinds.hpp"

namespace qerr {

const EncoderKind& first_kind(bool at_joint) {
  const auto& kinds = encoder_kinds();
  return *std::find_if(kinds.begin(), kinds.end(), [&](const EncoderKind& kind) {
    return (kind.resolution_at_joint != nullptr) == at_joint;
  });
}

std::vector<std::string> encoder_keys() {
  std::vector<std::string> keys;
  for (const EncoderKind& kind : encoder_kinds())
    for (const Parameter& row : encoder_parameters(kind))
      if (std::find(keys.begin(), keys.end(), row.name) == keys.end()) keys.emplace_back(row.name);
  return keys;
}

std::vector<Parameter> all_keys_of(const EncoderKind& kind) {
  std::vector<Parameter> rows = kind.parameters;
  for (const Parameter& p : common_encoder_parameters()) rows.push_back(p);
  return rows;
}

namespace {

/// Some vendors count lines in `cpr` and `ppr`, others counts: a factor of 4.
void refuse_ambiguous_keys(const Field& f) {
  for (const auto& [key, value] : read_map(f))
    for (const EncoderKind& kind : encoder_kinds())
      for (const std::string& ambiguous : words_of(kind.ambiguous_keys))
        if (key.name == ambiguous)
          throw Error(
              {key.place, value.path,
               "'" + key.name + "' is ambiguous: vendors use it for lines and for counts, 4 times as many",
               "'" + key.name + "'", std::string(kind.ambiguous_remedy)});
}

std::vector<std::string> list_of_kinds() {
  std::vector<std::string> names;
  for (const EncoderKind& kind : encoder_kinds()) names.emplace_back(kind.name);
  return names;
}

bool has_row(const std::vector<Parameter>& rows, std::string_view key) {
  return std::any_of(rows.begin(), rows.end(), [&](const Parameter& p) { return p.name == key; });
}

/// @throws Error (input) for keys that no encoder has, and for those that the kind does not have
void check_keys(const Field& f, const EncoderKind* kind) {
  const std::vector<std::string> known = encoder_keys();
  std::vector<Fault> faults;
  for (const Node::Entry& entry : f.node->entries) {
    const std::string& key = entry.key.name;
    if (std::find(known.begin(), known.end(), key) == known.end())
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
      throw Error({f.node->find(kind.name)->place, f.path_of(kind.name), "has the wrong kind of unit",
                   quoted(text), "write " + std::string(other.name) + ": " + number});
}

const EncoderKind& stated_kind(const Field& f) {
  const EncoderKind* found = nullptr;
  for (const EncoderKind& kind : encoder_kinds()) {
    if (!f.node->find(kind.name)) continue;
    if (found)
      throw Error({f.node->place, f.path, "an encoder must be stated in one way",
                   "'" + std::string(found->name) + "' and '" + std::string(kind.name) + "'",
                   "keep one of them"});
    found = &kind;
  }
  check_keys(f, found);
  if (found) return *found;
  throw Error({f.node->place, f.path, "the encoder's counts are missing", described(*f.node),
               "give one of " + did_you_mean("", list_of_kinds()).substr(7)});
}

}  // namespace

void refuse_bare_encoder(const Field& f, const Chain& chain) {
  const std::vector<std::string> keys = encoder_keys(), joints = joint_names(chain);
  if (f.node->type != Node::Type::mapping) return;
  for (const Node::Entry& entry : f.node->entries)
    if (std::find(keys.begin(), keys.end(), entry.key.name) != keys.end() &&
        std::find(joints.begin(), joints.end(), entry.key.name) == joints.end())
      throw Error({entry.key.place, f.path_of(entry.key.name), "this is a key of an encoder, not a joint",
                   quoted(entry.key.name),
                   "name the joints: '*': {" + std::string(first_kind(false).example) + "} for all"});
}

const EncoderKind& encoder_kind_of(const Field& f) {
  if (f.node->type != Node::Type::mapping)
    throw Error(f.fault("must be a mapping", "write {" + std::string(first_kind(false).example) + "}"));
  refuse_ambiguous_keys(f);
  const EncoderKind& kind = stated_kind(f);
  refuse_kind_as_unit(f, kind);
  return kind;
}

namespace {

/// The kind whose key the entry has; null if it has none.
const EncoderKind* stated_kind(const Node& entry) {
  for (const EncoderKind& kind : encoder_kinds())
    if (entry.find(kind.name)) return &kind;
  return nullptr;
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
      throw Error({own.node->place, own.path,
                   "the entry states no gear_ratio, but " + pattern.path +
                       ", which it replaces wholly, has gear_ratio: " + value,
                   described(*own.node),
                   "add gear_ratio: " + value + ", or gear_ratio: 1 for an encoder at the joint"});
    warnings.push_back(own.path + " states no " + name + ": " + default_of(row) + ", where " + pattern.path +
                       ", which it replaces wholly, has " + name + ": " + value + "; write " + name +
                       " to say which is meant");
  }
}

}  // namespace

void compare_with_patterns(const JointEntry& entry, std::vector<std::string>& warnings) {
  if (!entry.own.node) return;
  for (const Field& pattern : entry.patterns)
    if (pattern.node->type == Node::Type::mapping) compare(entry.own, pattern, warnings);
}

void warn_of_gear(const Field& entry, std::vector<std::string>& warnings) {
  const Node* ratio = entry.node->find("gear_ratio");
  std::string why;
  const auto value = ratio ? parse_quantity(ratio->text, why) : std::nullopt;
  if (!value || std::abs(value->value) >= 1) return;
  const std::string text = entry.path + ".gear_ratio: " + ratio->text +
                           " makes the encoder coarser at the joint: it is encoder revolutions per joint "
                           "revolution; is it inverted? Write " +
                           significant(1 / value->value, 4) + " if the joint is the slow side";
  if (std::find(warnings.begin(), warnings.end(), text) == warnings.end()) warnings.push_back(text);
}

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
  if (std::find(warnings.begin(), warnings.end(), text) == warnings.end()) warnings.push_back(text);
}

}  // namespace qerr
