#include "input/object_reader.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>

#include "core/text.hpp"
#include "input/read_sections.hpp"
#include "qerr/encoder/encoder.hpp"
#include "qerr/filter/family.hpp"

namespace qerr {

namespace {

/// A kind of quantity as people call it, and units in which it is usually written.
struct QuantityName {
  Dimension dimension;
  std::string_view name, units;
};

constexpr QuantityName quantity_names[]{
    {dimension::none, "a plain number", ""},
    {dimension::angle, "an angle", "rad, mrad, deg, arcmin or arcsec"},
    {dimension::length, "a length", "m, mm or um"},
    {dimension::time, "a time", "s, ms or us"},
    {dimension::frequency, "a frequency", "Hz or kHz"},
    {dimension::speed, "a speed", "m/s or mm/s"},
    {dimension::angular_speed, "an angular speed", "rad/s, deg/s or rpm"},
    {{1, 0, -2}, "an acceleration", "m/s^2 or mm/s^2"},
    {{0, 1, -2}, "an angular acceleration", "rad/s^2 or deg/s^2"},
};

/// "nearest or down", "x4, x2 or x1".
std::string one_of(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
  return text;
}

/// What may stand for a missing value in a remedy.
std::string placeholder(const Parameter& p) {
  if (p.kind == Kind::choice) return one_of(choices_of(p));
  return p.least == p.most ? shortest(p.least) : "...";
}

/// The value in the unit of the row. @throws Error (input) for a unit of another kind
double in_dimension(const Field& f, const Quantity& q, const Parameter& p, Dimension expected) {
  if (!q.dimension || *q.dimension == expected) return q.value;
  // A filter does not know which coordinates it will pass.
  const bool any_coordinate = p.coordinate && expected == dimension::none;
  if (any_coordinate && (*q.dimension == dimension::angle || *q.dimension == dimension::length))
    return q.value;
  if (p.angular && *q.dimension == dimension::angular_speed) return q.value / (2 * std::numbers::pi);
  const std::string or_angular = p.angular ? ", or an angular frequency in rad/s" : "";
  f.refuse("has the wrong kind of unit: this is " + name_of(*q.dimension),
           any_coordinate ? "give an angle or a length" : unit_remedy(expected) + or_angular);
}

/// "give a value of at least 1", "give a value above 0 and below 500 Hz", ...
std::string range_remedy(const Parameter& p, Dimension expected) {
  const std::string unit = unit_name(expected).empty() ? "" : ' ' + unit_name(expected);
  if (p.least == p.most) return "give " + shortest(p.least) + unit;
  std::string range;
  if (p.least < 0 && p.least == -p.most)
    return (p.kind == Kind::integer ? "give a whole number" : "give a value") + std::string(" of at most ") +
           shortest(p.most) + unit + " in magnitude";
  if (std::isfinite(p.least)) range = (p.open_below ? "above " : "of at least ") + shortest(p.least);
  if (std::isfinite(p.most))
    range += (range.empty() ? (p.open_above ? "" : "of ") : " and ") +
             std::string(p.open_above ? "below " : "at most ") + shortest(p.most);
  return (p.kind == Kind::integer ? "give a whole number" : "give a value") +
         (range.empty() ? "" : ' ' + range + unit);
}

bool in_range(const Parameter& p, double v) {
  return (p.open_below ? v > p.least : v >= p.least) && (p.open_above ? v < p.most : v <= p.most);
}

/// A misspelt key is one mistake: the key that is missing for it is not reported as well.
void drop_explained(std::vector<Fault>& missing, const std::vector<Fault>& unknown,
                    const std::vector<std::string>& known) {
  const auto last_key = [](const Fault& f) { return f.key.substr(f.key.rfind('.') + 1); };
  std::size_t unmatched = 0;
  for (const Fault& fault : unknown) {
    const std::string meant = nearest(last_key(fault), known);
    const auto found = std::ranges::find_if(missing, [&](const Fault& m) { return last_key(m) == meant; });
    found == missing.end() ? void(++unmatched) : void(missing.erase(found));
  }
  missing.erase(missing.begin(), missing.begin() + std::min(unmatched, missing.size()));
}

/// `bits: 17` of a text `bits:17`; "" for any other text.
std::string with_space_after_colon(const std::string& text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 >= text.size() || text[colon + 1] == ' ')
    return "";
  const std::string key = text.substr(0, colon);
  const bool plain = std::ranges::all_of(key, [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) ||
           std::string_view("_*?[]-").find(c) != std::string_view::npos;
  });
  const bool path = text[colon + 1] == '/' || text[colon + 1] == '\\' || text[colon + 1] == ':';
  return plain && !path ? key + ": " + text.substr(colon + 1) : "";
}

/// Instead of a mapping with known keys: says which keys it needs, `write {length: ...}`.
void require_mapping(const Field& f, const std::vector<Parameter>& format) {
  if (f.node->type == Node::Type::mapping) return;
  std::string keys;
  for (const Parameter& p : format)
    if (p.required) keys += (keys.empty() ? "" : ", ") + std::string(p.name) + ": ...";
  if (f.node->type == Node::Type::null || keys.empty() ||
      (f.node->type == Node::Type::scalar && !with_space_after_colon(f.node->text).empty()))
    read_map(f);
  f.refuse("must be a mapping", "write {" + keys + "}");
}

/// Where a key belongs that stands in the wrong mapping; "" if no section has it, or several have.
std::string home_of(std::string_view key) {
  std::string found;
  int homes = 0;
  const auto count = [&](const std::vector<Parameter>& rows, const char* home) {
    if (has_row(rows, key) && found != home) found = home, ++homes;
  };
  count(spec_format::top, "at the left margin, beside robot and encoders");
  count(spec_format::robot, "in robot: {...}");
  count(spec_format::configurations, "in configurations: {...}");
  count(spec_format::threshold, "in threshold: {...}");
  count(spec_format::motion, "in motion: {...}");
  count(spec_format::requirement(), "in an entry of requirements: [...]");
  count(spec_format::joint_motion, "in a joint of motion: {joints: {...}}");
  count(spec_format::filter(), "in an entry of filters: {...}");
  count(spec_format::sine, "in an entry of sines: [...]");
  count(spec_format::effect, "in an entry of effects: [...]");
  count(spec_format::sweep, "in an entry of sweep: [...]");
  count(spec_format::lowpass, "in the filter's lowpass: {...}");
  for (const FilterFamily& family : filter_families())
    count(family.parameters, "in the filter's lowpass: {...}");
  for (const EncoderKind& kind : encoder_kinds())
    count(encoder_parameters(kind), "in an entry of encoders: {...}");
  return homes == 1 ? found : "";
}

/// `{at_most: 0,02 deg}` has the entries `at_most: 0` and `02 deg`.
std::optional<Fault> after_decimal_comma(const Field& map, const Node::Entry& entry) {
  const auto& entries = map.node->entries;
  const std::string& rest = entry.key.name;
  if (entry.value.type != Node::Type::null || rest.empty() || rest[0] < '0' || rest[0] > '9')
    return std::nullopt;
  for (std::size_t i = 1; i < entries.size(); ++i)
    if (&entries[i] == &entry && entries[i - 1].value.type == Node::Type::scalar) {
      const std::string text = entries[i - 1].value.text + ',' + rest;
      const NumberAdvice advice = advice_on_number(text, "");
      if (advice.remedy.empty()) return std::nullopt;
      return Fault{entries[i - 1].value.place, map.path_of(entries[i - 1].key.name), advice.rule,
                   quoted(text), advice.remedy};
    }
  return std::nullopt;
}

/// Whether an empty section precedes the entry, so that the entry was probably meant to be in it.
const Node::Entry* empty_section_before(const Node& map, const Node::Entry& entry) {
  const Node::Entry* section = nullptr;
  for (const Node::Entry& other : map.entries) {
    if (&other == &entry) return section;
    const bool empty = other.value.type == Node::Type::null;
    if (empty || has_row(spec_format::top, other.key.name)) section = empty ? &other : nullptr;
  }
  return nullptr;
}

Fault unknown_key(const Field& map, const Node::Entry& entry, const std::vector<std::string>& known) {
  const std::string& name = entry.key.name;
  const std::string path = map.path_of(name);
  if (const std::string corrected = with_space_after_colon(name);
      !corrected.empty() && entry.value.type == Node::Type::null)
    return {entry.key.place, path, "a colon after a key must be followed by a space", quoted(name),
            "write " + quoted(corrected)};
  if (name.starts_with("//") || name.starts_with(';') || name.starts_with("--"))
    return {entry.key.place, path, "unknown key", quoted(name), "a comment begins with #"};
  if (const std::size_t equals = name.find('='); equals != std::string::npos && equals > 0)
    return {entry.key.place, path, "a key is followed by a colon, not by =", quoted(name),
            "write 'key: value'"};
  if (auto fault = after_decimal_comma(map, entry)) return *fault;
  if (const Node::Entry* section = empty_section_before(*map.node, entry))
    return {entry.key.place, path, "unknown key beside '" + section->key.name + "', which is empty",
            quoted(name), "indent by two spaces what belongs into " + section->key.name};
  // `order` of `polynomial_order`.
  const auto part =
      std::ranges::find_if(known, [&](const std::string& key) { return key.ends_with('_' + name); });
  if (part != known.end())
    return {entry.key.place, path, "unknown key", quoted(name), "did you mean " + quoted(*part) + "?"};
  std::string remedy = did_you_mean(name, known);
  if (const std::string home = remedy.starts_with("did") ? "" : home_of(name);
      !home.empty() && !(path.ends_with(".lowpass." + name) && home.find("lowpass") != std::string::npos))
    remedy = quoted(name) + " belongs " + home;
  return {entry.key.place, path, "unknown key", quoted(name), remedy};
}

}  // namespace

std::string name_of(const Dimension& d) {
  for (const QuantityName& q : quantity_names)
    if (q.dimension == d) return std::string(q.name);
  return "a quantity in " + unit_name(d);
}

std::string unit_remedy(const Dimension& d) {
  for (const QuantityName& q : quantity_names)
    if (q.dimension == d)
      return "give " + std::string(q.name) + (q.units.empty() ? "" : " in " + std::string(q.units));
  return "give a number in " + unit_name(d);
}

double read_number(const Field& f, const Parameter& p, Dimension coordinate) {
  const Dimension expected = p.coordinate ? coordinate : p.dimension;
  if (f.node->type != Node::Type::scalar) f.refuse("must be a number", unit_remedy(expected));
  std::string why;
  const auto quantity = parse_quantity(f.node->text, why);
  if (!quantity) {
    const NumberAdvice advice = advice_on_number(f.node->text, why);
    f.refuse(advice.rule, advice.remedy.empty() ? unit_remedy(expected) : advice.remedy);
  }
  if (f.node->quoted && !quantity->dimension)
    f.refuse("must be a number, not text", "remove the quotation marks");
  const double value = in_dimension(f, *quantity, p, expected);
  if (!in_range(p, value)) f.refuse("is out of range", range_remedy(p, expected));
  if (p.nonzero && value == 0)
    f.refuse("must not be zero", "give " + std::string(p.meaning.substr(0, p.meaning.find(';'))));
  const Parameter possible = with_physical_range(p, coordinate);
  if (!in_range(possible, value)) f.refuse("is beyond any machine", range_remedy(possible, expected));
  if (p.kind == Kind::integer && value != std::floor(value))
    f.refuse("must be an integer", range_remedy(p, expected));
  return value;
}

void warn_of_bare_numbers(const Field& map, const std::vector<Parameter>& rows, Dimension coordinate,
                          std::vector<std::string>& warnings) {
  for (const Parameter& p : rows) {
    const Node* value = map.node->find(p.name);
    const auto number = value && value->type == Node::Type::scalar ? parse_number(value->text) : std::nullopt;
    if (!number || std::abs(*number) < p.usual) continue;
    const std::string text = map.path_of(p.name) + ": " + value->text + " without a unit is in " +
                             unit_name(p.coordinate ? coordinate : p.dimension) +
                             ", which is much; write the unit that is meant";
    add_once(warnings, text);
  }
}

void warn_of_degrees(const Field& f, double turns, std::vector<std::string>& warnings) {
  const auto number =
      f.node && f.node->type == Node::Type::scalar ? parse_number(f.node->text) : std::nullopt;
  if (!number || std::abs(*number) <= turns * 2 * std::numbers::pi) return;
  warnings.push_back(f.path + ": " + f.node->text + " without a unit is in rad, " +
                     significant(std::abs(*number) / (2 * std::numbers::pi), 3) +
                     " revolutions; degrees need their unit, '" + f.node->text + " deg'");
}

std::string read_choice(const Field& f, const Parameter& p) {
  const std::vector<std::string> known = choices_of(p);
  const std::string near = f.node->type == Node::Type::scalar ? did_you_mean(f.node->text, known) : "";
  const std::string remedy = near.starts_with("did") ? near : "give " + one_of(known);
  if (f.node->type != Node::Type::scalar || !contains(known, f.node->text))
    f.refuse("is not one of the choices", remedy);
  return f.node->text;
}

std::string read_text_value(const Field& f) {
  if (f.node->type != Node::Type::scalar || f.node->text.empty())
    f.refuse("must be text", "give one name or path");
  if (!f.node->quoted && (f.node->text == "~" || f.node->text == "null"))
    f.refuse("must be text", "quote it if this is the name");
  return f.node->text;
}

std::size_t read_name(const Field& map, std::string_view key, const std::vector<std::string>& names,
                      const char* unknown) {
  const Node* const name = map.node->type == Node::Type::mapping ? map.node->find(key) : nullptr;
  if (!name) map.refuse_missing(key, "add '" + std::string(key) + ": ...' (" + did_you_mean("", names) + ")");
  const Field field{name, map.path_of(key)};
  const auto found = std::ranges::find(names, read_text_value(field));
  if (found == names.end()) field.refuse(unknown, did_you_mean(name->text, names));
  return found - names.begin();
}

std::vector<Field> read_list(const Field& f, const std::string& example) {
  if (f.node->type == Node::Type::null)
    f.refuse("must be a list", "write " + example + ", or leave the key out");
  if (f.node->type != Node::Type::sequence) f.refuse("must be a list", "write " + example);
  std::vector<Field> items;
  for (std::size_t i = 0; i < f.node->items.size(); ++i)
    items.push_back({&f.node->items[i], f.path + '[' + std::to_string(i) + ']'});
  return items;
}

std::vector<std::pair<Node::Key, Field>> read_map(const Field& f) {
  if (f.node->type == Node::Type::null)
    f.refuse("must be a mapping", "indent its entries by two spaces below it, or leave the key out");
  if (f.node->type == Node::Type::scalar)
    if (const std::string corrected = with_space_after_colon(f.node->text); !corrected.empty())
      f.refuse("a colon after a key must be followed by a space", "write " + quoted(corrected));
  if (f.node->type != Node::Type::mapping) f.refuse("must be a mapping", "write 'name: value'");
  std::vector<std::pair<Node::Key, Field>> entries;
  for (const auto& [key, value] : f.node->entries)
    entries.emplace_back(key, Field{&value, f.path_of(key.name)});
  return entries;
}

Object::Object(const Field& field, const std::vector<Parameter>& format) : field_(field), format_(format) {
  const std::vector<std::string> known = names_of(format);
  std::vector<Fault> faults;
  require_mapping(field, format);
  for (const Node::Entry& entry : field.node->entries)
    if (!contains(known, entry.key.name)) add_unknown_key(field, entry, known, faults);
  std::vector<Fault> missing;
  for (const Parameter& p : format)
    if (p.required && !has(p.name))
      missing.push_back(
          {field.node->place, field.path_of(p.name), "missing key", "",
           "add '" + std::string(p.name) + ": " + placeholder(p) + "' (" + std::string(p.meaning) + ")"});
  drop_explained(missing, faults, known);
  faults.insert(faults.end(), missing.begin(), missing.end());
  if (!faults.empty()) throw Error(faults);
}

Field Object::at(std::string_view key) const { return {field_.node->find(key), field_.path_of(key)}; }

const Parameter& Object::row(std::string_view key) const { return *find_named(format_, key); }

std::optional<double> Object::number(std::string_view key, Dimension coordinate) const {
  const Parameter& p = row(key);
  return has(key) ? std::optional(read_number(at(key), p, coordinate)) : p.fallback;
}

std::string Object::choice(std::string_view key) const {
  const Parameter& p = row(key);
  return has(key) ? read_choice(at(key), p) : choices_of(p).front();
}

std::optional<std::string> Object::text(std::string_view key) const {
  return has(key) ? std::optional(read_text_value(at(key))) : std::nullopt;
}

std::map<std::string, double> Object::numbers(const std::vector<Parameter>& rows,
                                              Dimension coordinate) const {
  std::map<std::string, double> values;
  for (const Parameter& p : rows)
    if (p.kind == Kind::number || p.kind == Kind::integer)
      if (const auto value = number(p.name, coordinate)) values[std::string(p.name)] = *value;
  return values;
}

std::map<std::string, std::string> Object::choices(const std::vector<Parameter>& rows) const {
  std::map<std::string, std::string> values;
  for (const Parameter& p : rows)
    if (p.kind == Kind::choice) values[std::string(p.name)] = choice(p.name);
  return values;
}

bool has_row(const std::vector<Parameter>& rows, std::string_view key) {
  return find_named(rows, key) != nullptr;
}

void add_unknown_key(const Field& map, const Node::Entry& entry, const std::vector<std::string>& known,
                     std::vector<Fault>& faults) {
  constexpr std::size_t most = 20;
  faults.push_back(faults.size() < most
                       ? unknown_key(map, entry, known)
                       : Fault{entry.key.place, map.path_of(entry.key.name), "unknown key", "", ""});
}

}  // namespace qerr
