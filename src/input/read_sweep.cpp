#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/text.hpp"
#include "input/design_request.hpp"
#include "input/read_sections.hpp"
#include "input/spec_variants.hpp"
#include "input/yaml_tree.hpp"

namespace qerr {

namespace {

Quantity end_of_range(const Object& o, const std::string& key) {
  if (!o.has(key)) o.self().refuse_missing(key, "give values: [...], or from, to and count");
  const Field f = o.at(key);
  std::string why = "must be a number";
  const auto quantity = f.node->type == Node::Type::scalar ? parse_quantity(f.node->text, why) : std::nullopt;
  if (!quantity) {
    const NumberAdvice advice = advice_on_number(f.node->text, why);
    f.refuse(advice.rule, advice.remedy.empty() ? "a number, with a unit if the key has one" : advice.remedy);
  }
  return *quantity;
}

/// A value as reports name it: a scalar without its quotation marks.
std::string name_of(const Node& value) { return value.type == Node::Type::scalar ? value.text : flow(value); }

SweepStep step_of(const std::vector<std::string>& keys, const std::vector<Field>& values) {
  SweepStep step;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    step.names.push_back(name_of(*values[k].node));
    step.changes.emplace_back(keys[k], flow(*values[k].node));
  }
  return step;
}

std::vector<SweepStep> range_steps(const Object& o, const std::string& axis) {
  const Quantity from = end_of_range(o, "from"), to = end_of_range(o, "to");
  if (from.dimension != to.dimension)
    o.at("to").refuse("must have the same kind of unit as 'from'", "give both in the same unit");
  const auto count = o.number("count");
  if (!count) o.self().refuse_missing("count", "add 'count: ...'");
  const bool log = o.choice("scale") == "log";
  if (log && !(from.value > 0 && to.value > 0))
    o.at("scale").refuse("a logarithmic range must have positive ends", "use scale: linear");
  const std::string unit = from.dimension ? " " + unit_name(*from.dimension) : "";
  const double last = *count - 1;
  std::vector<SweepStep> steps;
  for (int i = 0; i <= static_cast<int>(last); ++i) {
    // The division comes last: between whole numbers whole steps are exact.
    const double value = i == 0      ? from.value
                         : i == last ? to.value
                         : log       ? from.value * std::pow(to.value / from.value, i / last)
                                     : from.value + (to.value - from.value) * i / last;
    const std::string text = shortest(value) + unit;
    steps.push_back({{text}, {{axis, text}}, {}});
  }
  return steps;
}

/// The values of one key.
std::vector<SweepStep> list_steps(const Object& o, const std::string& axis) {
  for (const char* key : {"from", "to", "count", "scale"})
    if (o.has(key)) o.at(key).refuse("cannot be combined with 'values'", "keep one of the two");
  std::vector<SweepStep> steps;
  for (const Field& value : read_list(o.at("values"), "[13, 15, 17]"))
    steps.push_back(step_of({axis}, {value}));
  return steps;
}

/// The values that several keys take together.
std::vector<SweepStep> joint_steps(const Object& o, const std::vector<std::string>& keys) {
  std::vector<SweepStep> steps;
  for (const Field& row : read_list(o.at("values"), "[[1, 2], [3, 4]]")) {
    const std::vector<Field> values = read_list(row, "[1, 2], a value for each of the keys");
    if (values.size() != keys.size())
      row.refuse("must have a value for each of the " + counted(keys.size(), "key"),
                 "give " + counted(keys.size(), "value") + " in each list");
    steps.push_back(step_of(keys, values));
  }
  return steps;
}

std::string path_of(const Spec& spec, const std::string& file) {
  const std::filesystem::path folder =
      spec.file == "-" ? std::filesystem::path(".") : std::filesystem::path(spec.file).parent_path();
  return (folder / file).string();
}

/// The rows of a catalogue, each the whole entry of an encoder.
std::vector<SweepStep> catalogue_steps(const Object& o, const std::string& axis, const Spec& spec) {
  for (const char* key : {"values", "from", "to", "count", "scale"})
    if (o.has(key)) o.at(key).refuse("cannot be combined with 'catalogue'", "keep one of the two");
  constexpr std::string_view section = "encoders.";
  if (!axis.starts_with(section))
    o.at("key").refuse("a catalogue has entries of encoders", "name a joint: encoders.JOINT");
  std::vector<SweepStep> steps;
  const Field file = o.at("catalogue");
  read_named_file(file, path_of(spec, *o.text("catalogue")), [&](const std::string& path) {
    for (const CatalogueRow& row : read_catalogue(path).rows) {
      SweepStep step{{row.name}, {{axis, flow(row.entry)}}, {}};
      for (const Node& effect : row.effects)
        step.effects.push_back(flow(on_joint(effect, axis.substr(section.size()))));
      steps.push_back(std::move(step));
    }
  });
  return steps;
}

/// @param used  keys of the entries before
SweepAxis axis_of(const Object& o, const Spec& spec, std::vector<std::string>& used) {
  SweepAxis axis;
  if (o.has("key") == o.has("keys"))
    throw Error(
        o.self().node->place, o.self().path + ".key",
        o.has("key") ? "cannot be combined with 'keys'" : "missing key", "",
        o.has("key") ? "keep one of the two" : "add 'key: ...' (dotted path of the value that varies)");
  if (o.has("key")) {
    axis.keys = {*o.text("key")};
  } else {
    for (const Field& key : read_list(o.at("keys"), "[encoders.a1.bits, encoders.a2.bits]"))
      axis.keys.push_back(read_text_value(key));
    if (axis.keys.empty()) o.at("keys").refuse("the list is empty", "give at least one key");
    if (!o.has("values"))
      o.self().refuse_missing("values",
                              "add values: [[...], ...], in each list a value for each of the keys");
  }
  // Each key is compared with those before it, and each axis is tried on the whole spec.
  constexpr std::size_t most_keys = 1000;
  if (used.size() + axis.keys.size() > most_keys)
    throw Error(o.self().node->place, o.self().path, "a sweep varies at most 1000 keys", "",
                "vary an entry wholly: {key: encoders.elbow, values: [{bits: 12}, ...]}");
  for (const std::string& key : axis.keys) {
    const auto same = std::ranges::find_if(used, [&](const auto& u) { return set_one_value(key, u); });
    if (same != used.end())
      o.at(o.has("key") ? "key" : "keys")
          .refuse("varies the same value twice: " + key + (*same == key ? "" : " and " + *same),
                  "name each value once in the sweep");
    used.push_back(key);
  }
  axis.steps = o.has("keys")        ? joint_steps(o, axis.keys)
               : o.has("catalogue") ? catalogue_steps(o, axis.keys[0], spec)
               : o.has("values")    ? list_steps(o, axis.keys[0])
                                    : range_steps(o, axis.keys[0]);
  if (axis.steps.empty()) o.at("values").refuse("the list is empty", "give at least one value");
  return axis;
}

}  // namespace

void read_sweep(const Field& f, Spec& spec, Faults& faults) {
  std::vector<std::string> used;
  for (const Field& item : read_list(f, "a list: - {key: ..., values: [...]}"))
    faults.guard([&] {
      const Object o(item, spec_format::sweep);
      spec.sweep.push_back(axis_of(o, spec, used));
    });
}

}  // namespace qerr
