#include "input/object_reader.hpp"

#include <algorithm>
#include <cmath>

#include "core/suggest.hpp"

namespace qerr {

namespace {

std::string unit_remedy(const Dimension& d) {
  const std::string unit = unit_name(d);
  return unit.empty() ? "a plain number" : "a number in " + unit + ", or with a unit of that kind";
}

/// "at least 1", "above 0 and below 500 Hz", ...
std::string range_text(const Parameter& p) {
  std::string text;
  if (std::isfinite(p.least)) text = (p.open_below ? "above " : "at least ") + shortest(p.least);
  if (std::isfinite(p.most))
    text +=
        (text.empty() ? "" : " and ") + std::string(p.open_above ? "below " : "at most ") + shortest(p.most);
  return text;
}

bool in_range(const Parameter& p, double v) {
  return (p.open_below ? v > p.least : v >= p.least) && (p.open_above ? v < p.most : v <= p.most);
}

}  // namespace

double read_number(const Field& f, const Parameter& p, Dimension coordinate) {
  const Dimension expected = p.coordinate ? coordinate : p.dimension;
  if (f.node->type != Node::Type::scalar) throw Error(f.fault("must be a number", unit_remedy(expected)));
  std::string why;
  const auto quantity = parse_quantity(f.node->text, why);
  if (!quantity) throw Error(f.fault(why, unit_remedy(expected)));
  if (f.node->quoted && !quantity->dimension)
    throw Error(f.fault("must be a number, not text", "remove the quotation marks"));
  if (quantity->dimension && *quantity->dimension != expected)
    throw Error(f.fault("has the wrong kind of unit", unit_remedy(expected)));
  if (!in_range(p, quantity->value))
    throw Error(f.fault("is out of range",
                        range_text(p) + (unit_name(expected).empty() ? "" : " " + unit_name(expected))));
  if (p.kind == Kind::integer && quantity->value != std::floor(quantity->value))
    throw Error(f.fault("must be an integer", range_text(p)));
  return quantity->value;
}

std::string read_choice(const Field& f, const Parameter& p) {
  const std::vector<std::string> known = choices_of(p);
  if (f.node->type != Node::Type::scalar ||
      std::find(known.begin(), known.end(), f.node->text) == known.end())
    throw Error(f.fault("is not one of the choices",
                        f.node->type == Node::Type::scalar ? did_you_mean(f.node->text, known) : "one word"));
  return f.node->text;
}

bool read_boolean(const Field& f) {
  if (f.node->type == Node::Type::scalar && !f.node->quoted) {
    if (f.node->text == "true") return true;
    if (f.node->text == "false") return false;
  }
  throw Error(f.fault("must be true or false", "true or false"));
}

std::string read_text_value(const Field& f) {
  if (f.node->type != Node::Type::scalar || f.node->text.empty())
    throw Error(f.fault("must be text", "a name or path on one line"));
  if (!f.node->quoted && (f.node->text == "~" || f.node->text == "null"))
    throw Error(f.fault("must be text", "quote it if this is the name"));
  return f.node->text;
}

std::vector<Field> read_list(const Field& f) {
  if (f.node->type != Node::Type::sequence) throw Error(f.fault("must be a list", "write [a, b, ...]"));
  std::vector<Field> items;
  for (std::size_t i = 0; i < f.node->items.size(); ++i)
    items.push_back({&f.node->items[i], f.path + '[' + std::to_string(i) + ']'});
  return items;
}

std::vector<std::pair<Node::Key, Field>> read_map(const Field& f) {
  if (f.node->type != Node::Type::mapping) throw Error(f.fault("must be a mapping", "write 'name: value'"));
  std::vector<std::pair<Node::Key, Field>> entries;
  for (const auto& [key, value] : f.node->entries)
    entries.emplace_back(key, Field{&value, f.path.empty() ? key.name : f.path + '.' + key.name});
  return entries;
}

Object::Object(const Field& field, const std::vector<Parameter>& format) : field_(field), format_(format) {
  std::vector<std::string> known;
  for (const Parameter& p : format) known.emplace_back(p.name);
  std::vector<Fault> faults;
  for (const auto& [key, value] : read_map(field))
    if (std::find(known.begin(), known.end(), key.name) == known.end())
      faults.push_back(
          {key.place, value.path, "unknown key", "'" + key.name + "'", did_you_mean(key.name, known)});
  for (const Parameter& p : format)
    if (p.required && !has(p.name))
      faults.push_back({field.node->place,
                        field.path.empty() ? std::string(p.name) : field.path + '.' + std::string(p.name),
                        "missing key", "",
                        "add '" + std::string(p.name) + ": ...' (" + std::string(p.meaning) + ")"});
  if (!faults.empty()) throw Error(faults);
}

Field Object::at(std::string_view key) const {
  return {field_.node->find(key),
          field_.path.empty() ? std::string(key) : field_.path + '.' + std::string(key)};
}

const Parameter& Object::row(std::string_view key) const {
  return *std::find_if(format_.begin(), format_.end(), [&](const Parameter& p) { return p.name == key; });
}

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

}  // namespace qerr
