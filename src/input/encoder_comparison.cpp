#include "input/encoder_comparison.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/text.hpp"
#include "qerr/encoder/encoder_kinds.hpp"

namespace qerr {

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
