#include "input/spec_variants.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/lists.hpp"
#include "core/text.hpp"
#include "input/design_request.hpp"
#include "input/joint_entries.hpp"
#include "input/read_sections.hpp"
#include "input/yaml_tree.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

namespace {

std::string section_of(const std::string& key) { return key.substr(0, key.find_first_of(".[")); }

/// Sections that say how designs are found, not what they are.
bool is_search(const std::string& section) { return section == "sweep" || section == "design"; }

Node changed_tree(const Spec& spec, const SpecOverrides& overrides) {
  Node root = parse_yaml(spec.text, spec.file);
  SpecReader reader(spec.file);
  apply_changes(root, spec_changes(overrides.values), reader.chain_of());
  return root;
}

SpecOverrides without(SpecOverrides overrides, std::size_t i) {
  overrides.values.erase(overrides.values.begin() + i);
  return overrides;
}

/// The spec with the first second of its motion at 1 kHz, or as many samples.
Spec at_the_beginning(Spec spec) {
  constexpr double samples = 1000;
  if (!spec.motion) return spec;
  Motion& m = *spec.motion;
  m.duration = std::min(m.duration, samples / m.sample_rate);
  if (m.settling) m.settling = std::min(*m.settling, 0.5 * m.duration);
  return spec;
}

/// A report of a spec as if no value had been set, which the report would print; empty if it cannot be made.
std::optional<std::string> text_of(const ReportText& report, Spec spec) {
  spec.overrides.clear();
  try {
    return report(spec);
  } catch (const Error&) {
    return std::nullopt;
  }
}

/// The report of the spec with all overrides, made once.
class ReportOfAll {
 public:
  ReportOfAll(const Spec& spec, const ReportText& report) : spec_(spec), report_(report) {}

  /// Whether the values or the report are those of the spec without an override. A spec that cannot be read
  /// or evaluated without it needs it.
  bool shows_no_change(const SpecOverrides& all, const SpecOverrides& others) {
    if (!report_) return false;
    try {
      if (same_meaning(changed_tree(spec_, all), changed_tree(spec_, others))) return false;
      const Spec before = parse_spec(spec_.text, spec_.file, others);
      if (spec_.motion) {  // the quick question first
        if (!begin_) begin_ = text_of(report_, at_the_beginning(spec_));
        if (*begin_ != text_of(report_, at_the_beginning(before))) return false;
      }
      if (!whole_) whole_ = text_of(report_, spec_);
      return *whole_ && *whole_ == text_of(report_, before);
    } catch (const Error&) {
      return false;
    }
  }

 private:
  const Spec& spec_;
  const ReportText& report_;
  std::optional<std::optional<std::string>> begin_, whole_;
};

void refuse_chosen_encoders(const Spec& spec, const SpecOverrides& overrides) {
  const auto same = [](const Encoder& a, const Encoder& b) {
    return a.resolution == b.resolution && a.accuracy == b.accuracy && a.rounding == b.rounding;
  };
  const auto chosen = [&](std::size_t joint) {
    return std::ranges::any_of(spec.design->encoders,
                               [&](const JointOptions& options) { return options.joint == joint; });
  };
  for (std::size_t i = 0; i < overrides.values.size(); ++i) {
    const auto& [key, value] = overrides.values[i];
    if (!key.starts_with("encoders.")) continue;
    std::vector<std::string> governed;
    bool governs = true;
    try {
      const Spec rest = parse_spec(spec.text, spec.file, without(overrides, i));
      const auto &encoders = spec.model.transmission.encoders, &before = rest.model.transmission.encoders;
      for (std::size_t j = 0; j < encoders.size() && encoders.size() == before.size(); ++j)
        if (!same(encoders[j], before[j]))
          governed.push_back(chosen(j) ? spec.model.chain.independent[j].name : "");
      governs = governed.empty() || std::ranges::count(governed, "") > 0;
    } catch (const Error&) {  // the spec needs the override
    }
    if (!governs)
      throw Error({"--set " + key, 0, 0}, key, "governs nothing: design.encoders chooses these encoders",
                  list_of_names(governed), "change what may be chosen, design.encoders, or leave it out");
  }
}

/// The filters of the changed spec, the low-passes that the section `design` chooses left out.
Node filters_that_hold(const Spec& spec, const SpecOverrides& overrides) {
  Node root = changed_tree(spec, overrides);
  Node* const filters = root.find("filters");
  if (!filters) return {};
  for (const FilterOptions& chosen : spec.design->filters)
    if (Node* const filter = filters->find(spec.filters[chosen.filter].name))
      std::erase_if(filter->entries, [](const Node::Entry& entry) { return entry.key.name == "lowpass"; });
  return *filters;
}

void refuse_chosen_filters(const Spec& spec, const SpecOverrides& overrides) {
  for (std::size_t i = 0; i < overrides.values.size(); ++i) {
    const std::string& key = overrides.values[i].first;
    if (!key.starts_with("filters.")) continue;
    const SpecOverrides others = without(overrides, i);
    bool governs = true;
    try {
      std::ignore = parse_spec(spec.text, spec.file, others);
      governs = same_meaning(changed_tree(spec, overrides), changed_tree(spec, others)) ||
                !same_meaning(filters_that_hold(spec, overrides), filters_that_hold(spec, others));
    } catch (const Error&) {  // the spec needs the override
    }
    if (!governs)
      throw Error({"--set " + key, 0, 0}, key, "governs nothing: design.filters chooses this low-pass", "",
                  "change what may be chosen, design.filters, or leave it out");
  }
}

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

void add_effect(Node& root, const Node& effect) {
  Node* list = root.find("effects");
  if (!list) {
    root.entries.push_back({{"effects", effect.place}, {}});
    list = &root.entries.back().value;
    list->type = Node::Type::sequence;
    list->place = effect.place;
  }
  const auto same = [&](const Node& other, std::string_view key) {
    const Node *const a = other.find(key), *const b = effect.find(key);
    return a && b && a->text == b->text;
  };
  const auto found = std::ranges::find_if(
      list->items, [&](const Node& other) { return same(other, "type") && same(other, "joint"); });
  if (found == list->items.end())
    list->items.push_back(effect);
  else
    *found = effect;
}

SpecVariants::SpecVariants(const std::string& text, const std::string& path, const SpecOverrides& overrides)
    : overrides_(spec_changes(overrides.values)),
      seed_(overrides.seed),
      reader_(path),
      base_(parse_spec(text, path, overrides)) {
  std::erase_if(overrides_, [](const SpecChange& change) { return is_search(section_of(change.first)); });
  root_ = parse_yaml(text, path);
  std::erase_if(root_.entries, [](const Node::Entry& entry) { return is_search(entry.key.name); });
  Node root = root_;
  warnings_ = apply_changes(root, overrides_, reader_.chain_of());
  reader_.read(root);
}

Spec SpecVariants::variant(const std::vector<SpecChange>& changes, const std::vector<Node>& effects) const {
  std::vector<std::string> changed;
  for (const SpecChange& change : changes)
    if (!contains(changed, section_of(change.first))) changed.push_back(section_of(change.first));
  if (!effects.empty() && !contains(changed, "effects")) changed.emplace_back("effects");
  const bool whole =
      std::ranges::any_of(changed, [](const std::string& s) { return !SpecReader::can_change(s); });
  Node root = mapping_node({});
  root.place = root_.place;
  const auto wanted = [&](const std::string& section) {
    return whole || SpecReader::reads_again(section, changed);
  };
  for (const Node::Entry& entry : root_.entries)
    if (wanted(entry.key.name)) root.entries.push_back(entry);
  std::vector<SpecChange> all;
  for (const SpecChange& override : overrides_)
    if (wanted(section_of(override.first))) all.push_back(override);
  all.insert(all.end(), changes.begin(), changes.end());
  SpecReader reader(base_.file);
  const auto base_chain = [&](const Node&) -> const Chain& { return base_.model.chain; };
  std::vector<std::string> warnings =
      apply_changes(root, all, whole ? reader.chain_of() : ChainOf(base_chain));
  for (const std::string& of_base : warnings_) add_once(warnings, of_base);
  for (const Node& effect : effects) add_effect(root, effect);

  Spec spec = whole ? reader.read(root) : reader_.reread(root, changed);
  spec.warnings.insert(spec.warnings.begin(), warnings.begin(), warnings.end());
  spec.text = base_.text;
  spec.sha256 = base_.sha256;
  spec.overrides = base_.overrides;
  for (const auto& [key, value] : changes) spec.overrides.emplace_back(key, flow(value));
  if (seed_) spec.configurations.seed = *seed_;
  return spec;
}

std::vector<std::string> idle_overrides(const Spec& spec, const SpecOverrides& overrides,
                                        const std::vector<std::string_view>& unused,
                                        const ReportText& report) {
  std::vector<std::string> warnings;
  ReportOfAll compared(spec, report);
  for (std::size_t i = 0; i < overrides.values.size(); ++i) {
    const std::string& key = overrides.values[i].first;
    const std::string section = section_of(key);
    if (contains(unused, section))
      warnings.push_back("--set " + key + ": this command does not use " + section);
    else if (compared.shows_no_change(overrides, without(overrides, i)))
      warnings.push_back("--set " + key + " changes no figure of this report");
  }
  return warnings;
}

void refuse_chosen(const Spec& spec, const SpecOverrides& overrides) {
  refuse_chosen_encoders(spec, overrides);
  refuse_chosen_filters(spec, overrides);
}

void refuse_varied(const Spec& spec, const SpecOverrides& overrides) {
  for (const SpecChange& change : spec_changes(overrides.values))
    for (const SweepAxis& axis : spec.sweep)
      for (const std::string& key : axis.keys)
        if (set_one_value(key, change.first))
          throw Error(change.second.place, change.first, "governs nothing: the sweep varies it",
                      "sweep key " + key, "leave it out, or replace the sweep: --set 'sweep=[...]'");
}

void read_sweep(const Field& f, Spec& spec, Faults& faults) {
  std::vector<std::string> used;
  for (const Field& item : read_list(f, "a list: - {key: ..., values: [...]}"))
    faults.guard([&] {
      const Object o(item, spec_format::sweep);
      spec.sweep.push_back(axis_of(o, spec, used));
    });
}

}  // namespace qerr
