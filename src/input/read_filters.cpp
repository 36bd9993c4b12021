#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/lists.hpp"
#include "core/text.hpp"
#include "input/joint_entries.hpp"
#include "input/read_sections.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/filter/family.hpp"
#include "simulate/estimators/estimator.hpp"

namespace qerr {

namespace {

std::vector<double> read_row(const Field& f, const Parameter& p) {
  if (f.node->type != Node::Type::sequence) return {read_number(f, {.name = p.name})};
  std::vector<double> row;
  for (const Field& item : read_list(f)) row.push_back(read_number(item, {.name = p.name}));
  return row;
}

Rows read_rows(const Field& f, const Parameter& p) {
  if (p.kind == Kind::number) return {{read_number(f, p)}};
  if (p.kind == Kind::matrix && f.node->type == Node::Type::scalar) return {read_row(f, p)};
  Rows rows;
  for (const Field& item : read_list(f)) {
    if (p.kind == Kind::numbers)
      rows.push_back({read_number(item, {.name = p.name})});
    else
      rows.push_back(read_row(item, p));
  }
  return rows;
}

void read_values(const Object& o, const std::vector<Parameter>& rows, std::map<std::string, Rows>& values) {
  for (const Parameter& p : rows) {
    if (!o.has(p.name)) continue;
    const std::string name(p.name);
    if (p.kind == Kind::choice)
      read_choice(o.at(p.name), p);
    else if (p.kind == Kind::text)
      read_text_value(o.at(p.name));
    else
      values[name] = read_rows(o.at(p.name), p);
  }
}

/// Whether the filter has the key of the representation or one of its companion keys.
bool uses(const Object& o, const FilterRepresentation& r) {
  return o.has(r.key.name) ||
         std::ranges::any_of(r.beside, [&](const Parameter& p) { return o.has(p.name); });
}

Filter represented(const Object& o, const FilterRepresentation& r, const FilterDesign& d) {
  std::vector<Parameter> needed{r.key};
  needed.front().required = true;
  needed.insert(needed.end(), r.beside.begin(), r.beside.end());
  for (const Parameter& p : needed)
    if (p.required && !o.has(p.name))
      o.self().refuse_missing(p.name,
                              "add '" + std::string(p.name) + ": ...' (" + std::string(p.meaning) + ")");
  std::map<std::string, Rows> values;
  read_values(o, r.beside, values);
  if (r.inside.empty())
    read_values(o, {r.key}, values);
  else
    read_values(Object(o.at(r.key.name), r.inside), r.inside, values);
  return r.build(values, d.sample_rate, d.derivative);
}

std::string keys_of_representations() {
  std::string text;
  for (const FilterRepresentation& r : filter_representations()) text += ", " + std::string(r.key.name);
  return text;
}

/// The unit of a control law's gain.
std::optional<Dimension> gain_unit(const Object& o, bool by_coefficients) {
  if (!o.has("unit")) return std::nullopt;
  const Field f = o.at("unit");
  if (!by_coefficients)
    f.refuse("a filter that is not given by coefficients has the unit of its derivative", "remove unit");
  std::string why;
  const auto unit = parse_unit(*o.text("unit"), why);
  if (!unit || unit->factor != unit->divisor)
    f.refuse(unit ? "must be an SI unit" : "must be a unit: " + why,
             "write unit: N m/rad, and the coefficients in it");
  return unit->dimension;
}

/// @param designed  set if a family has made the filter
Filter design(const Object& o, std::shared_ptr<const FamilyDesign>& designed) {
  FilterDesign d;
  d.derivative = static_cast<int>(*o.number("derivative"));
  d.sample_rate = *o.number("sample_rate");
  const FilterRepresentation* chosen = nullptr;
  for (const FilterRepresentation& r : filter_representations()) {
    if (!uses(o, r)) continue;
    const std::string_view other = o.has("lowpass") ? "lowpass" : chosen ? chosen->key.name : "";
    if (!other.empty())
      o.at(o.has(other) ? other : r.key.name)
          .refuse("a filter must be given in one way, not by " + std::string(r.key.name) + " and " +
                      std::string(other),
                  "keep one");
    chosen = &r;
  }
  const std::optional<Dimension> unit = gain_unit(o, chosen != nullptr);
  if (chosen) {
    Filter filter = represented(o, *chosen, d);
    filter.unit = unit;
    if (!unit && o.has("derivative")) filter.unit = Dimension{.second = -d.derivative};
    return filter;
  }
  if (!o.has("lowpass")) {
    if (!o.has("derivative"))
      throw Error(o.self().node->place, o.self().path, "the filter has no effect", described(*o.self().node),
                  "give derivative, lowpass" + keys_of_representations());
    return difference_filter(d.sample_rate, d.derivative);
  }
  const Field lowpass = o.at("lowpass");
  if (lowpass.node->type != Node::Type::mapping)
    lowpass.refuse("must be a mapping",
                   "write {family: " + std::string(filter_families().front().name) + ", ...}");
  const FilterFamily& family = read_member(lowpass, "family", filter_families(), "no such filter family");
  std::vector<Parameter> format = spec_format::lowpass;
  format.insert(format.end(), family.parameters.begin(), family.parameters.end());
  const Object parameters(lowpass, format);
  d.numbers = parameters.numbers(family.parameters);
  d.choices = parameters.choices(family.parameters);
  designed = std::make_shared<FamilyDesign>(FamilyDesign{&family, d});
  return family.design(d);
}

/// The value in a mapping that a key of a filter design names, such as `cutoff` or `sos[2]`; null if absent.
const Node* named(const Node& holder, const std::string& key) {
  const std::size_t bracket = key.find('[');
  const Node* value = holder.find(key.substr(0, bracket));
  if (!value || bracket == std::string::npos || value->type != Node::Type::sequence) return value;
  const auto index = static_cast<std::size_t>(std::stoul(key.substr(bracket + 1)));
  return index < value->items.size() ? &value->items[index] : value;
}

/// Faults of a filter design name its parameters only; this adds file, line and path.
Error placed(const Error& e, const Field& f) {
  std::vector<std::pair<const Node*, std::string>> holders{{f.node, f.path + '.'}};
  std::vector<std::string_view> inner{"lowpass"};
  for (const FilterRepresentation& r : filter_representations())
    if (!r.inside.empty()) inner.push_back(r.key.name);
  for (const std::string_view key : inner)
    if (const Node* node = f.node->find(key); node && node->type == Node::Type::mapping)
      holders.emplace_back(node, f.path + '.' + std::string(key) + '.');
  std::vector<Fault> faults = e.faults();
  for (Fault& fault : faults) {
    if (!fault.place.file.empty()) continue;
    for (const auto& [holder, path] : holders)
      if (const Node* value = named(*holder, fault.key)) {
        fault.place = value->place;
        fault.key = path + fault.key;
        break;
      }
    if (fault.place.file.empty()) {
      const auto& [holder, path] = holders.back();
      fault.place = holder->place;
      fault.key = fault.key.empty() ? f.path : path + fault.key;
    }
  }
  return Error(faults, e.trouble());
}

/// The order of the derivative that a filter's name promises: `velocity`, `joint_vel`, `acc`; 0 if none.
int promised_derivative(const std::string& name) {
  std::string lower = ' ' + lower_case(name) + ' ';
  std::ranges::replace_if(
      lower, [](char c) { return !std::isalpha(static_cast<unsigned char>(c)); }, ' ');
  const auto has = [&](std::string_view part) { return lower.find(part) != std::string::npos; };
  if (has("jerk")) return 3;
  if (has("accel") || has(" acc ")) return 2;
  return has("veloc") || has("speed") || has(" vel ") ? 1 : 0;
}

/// A filter estimates what `derivative` says; its name says nothing to the program, but much to its reader.
void warn_of_name(const std::string& path, const std::string& name, const Object& o,
                  std::vector<std::string>& warnings) {
  const int promised = promised_derivative(name), derivative = static_cast<int>(*o.number("derivative"));
  if (promised == 0 || promised == derivative || (derivative == 0 && o.has("derivative"))) return;
  const std::string order = std::to_string(promised);
  warnings.push_back(
      derivative == 0
          ? path +
                " has no 'derivative:' and estimates a position; if it is to estimate what it is named "
                "after, add 'derivative: " +
                order + "'; if not, 'derivative: 0'"
          : path + " has 'derivative: " + std::to_string(derivative) + "', and its name suggests " + order);
}

}  // namespace

// Cut-off and sample rate hundreds of orders of magnitude apart exceed the range of double: a fault of the
// spec.
Norms checked_norms(const Filter& filter) {
  const auto out_of_range = [&](const std::string& found) {
    return Error(
        "", "the norms of the filter exceed the range of double precision", found,
        filter.designed ? "bring cut-off and sample rate closer together" : "scale its coefficients");
  };
  const auto silent = [] {
    return Error("", "the filter passes nothing: its output is always 0", "a gain of 0", "leave it out");
  };
  if (!filter.designed && filter.gain.hi == 0) throw silent();  // of a design it is an underflow
  Norms n;
  try {
    n = norms(filter);
  } catch (const Error& e) {
    throw out_of_range(e.faults().front().found);
  }
  if (n.h2 == 0) throw silent();
  if (std::isfinite(n.h2) && !std::isfinite(n.l1.upper))
    throw Error("", "the l1 norm of the filter cannot be bounded: its poles are too close to the unit circle",
                "largest pole modulus " + shortest(poles_max_modulus(filter)),
                "damp the filter, or lower its order");
  if (!std::isfinite(n.h2) || !std::isfinite(n.l1.upper) || !std::isfinite(n.dc_gain))
    throw out_of_range("H2 norm " + shortest(n.h2));
  return n;
}

void read_filters(const Field& f, const RobotModel& robot, Spec& spec, Faults& faults) {
  for (const auto& entry : read_map(f)) {
    const Node::Key& key = entry.first;
    const Field& field = entry.second;
    faults.guard([&] {
      if (key.name == "position" || key.name.empty())
        throw Error(key.place, field.path, "the name is reserved: 'position' is the unfiltered coordinate",
                    "'" + key.name + "'", "choose another name");
      const Object o(field, spec_format::filter());
      warn_of_name(field.path, key.name, o, spec.warnings);
      try {
        std::shared_ptr<const FamilyDesign> designed;
        const Filter filter = design(o, designed);
        spec.filters.push_back({key.name, filter, checked_norms(filter), std::move(designed)});
      } catch (const Error& e) {
        throw placed(e, field);
      }
      if (o.has("joints"))
        spec.filters.back().joints = find_joints(robot, spec.model.chain, *o.text("joints"),
                                                 o.at("joints").node->place, o.at("joints").path);
    });
  }
}

/// Reads the section `estimators` of a spec.
namespace {

const EstimatorKind& kind_of(const Field& f) {
  constexpr const char* unknown = "no such estimator";
  const Node* name = f.node->type == Node::Type::mapping ? f.node->find("kind") : nullptr;
  if (name && find_named(filter_families(), name->text))
    Field{name, f.path_of("kind")}.refuse(unknown, "write it in filters: {" + name->text +
                                                       ": {derivative: 1, lowpass: {family: " + name->text +
                                                       "}}}: it is a linear filter");
  return read_member(f, "kind", estimator_kinds(), unknown);
}

}  // namespace

void read_estimators(const Field& f, const RobotModel& robot, Spec& spec, Faults& faults) {
  for (const auto& [key, field] : read_map(f)) {
    const auto& name = key;
    const Field& entry = field;
    faults.guard([&] {
      const EstimatorKind& kind = kind_of(entry);
      if (find_named(spec.filters, name.name))
        throw Error(name.place, entry.path, "a filter has the same name", quoted(name.name),
                    "choose another name: reports have both in one table");
      std::vector<Parameter> format = spec_format::estimator;
      format.insert(format.end(), kind.parameters.begin(), kind.parameters.end());
      const Object o(entry, format);
      EstimatorDesign d{
          name.name, std::string(kind.name), o.numbers(kind.parameters), o.choices(kind.parameters), {}};
      if (o.has("joints"))
        d.joints = find_joints(robot, spec.model.chain, *o.text("joints"), o.at("joints").node->place,
                               o.at("joints").path);
      spec.estimators.push_back(std::move(d));
    });
  }
}

}  // namespace qerr
