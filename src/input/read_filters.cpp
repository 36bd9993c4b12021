#include <algorithm>
#include <cmath>

#include "qerr/core/suggest.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/input/spec_format.hpp"
#include "read_sections.hpp"

namespace qerr {

namespace {

const FilterFamily& family_of(const Field& f) {
  std::vector<std::string> known;
  for (const FilterFamily& family : filter_families()) known.emplace_back(family.name);
  const Node* name = f.node->type == Node::Type::mapping ? f.node->find("family") : nullptr;
  if (!name)
    throw Error({f.node->place, f.path + ".family", "missing key", "",
                 "add 'family: ...' (" + did_you_mean("", known) + ")"});
  const Field field{name, f.path + ".family"};
  const std::string text = read_text_value(field);
  for (const FilterFamily& family : filter_families())
    if (family.name == text) return family;
  throw Error(field.fault("no such filter family", did_you_mean(text, known)));
}

std::vector<double> read_coefficients(const Object& o, const std::string& key) {
  std::vector<double> values;
  for (const Field& item : read_list(o.at(key))) values.push_back(read_number(item, {.name = key}));
  return values;
}

Filter design(const Object& o) {
  FilterDesign d;
  d.derivative = static_cast<int>(*o.number("derivative"));
  d.sample_rate = *o.number("sample_rate");
  if (o.has("numerator") || o.has("denominator")) {
    if (o.has("lowpass"))
      throw Error(o.at("lowpass").fault("a filter is given by coefficients or by a low-pass, not by both",
                                        "keep one"));
    if (!o.has("numerator"))
      throw Error(
          {o.self().node->place, o.self().path + ".numerator", "missing key", "", "add 'numerator: [...]'"});
    d.lists["numerator"] = read_coefficients(o, "numerator");
    d.lists["denominator"] =
        o.has("denominator") ? read_coefficients(o, "denominator") : std::vector<double>{1.0};
    return filter_from_coefficients(d.lists["numerator"], d.lists["denominator"], d.sample_rate,
                                    d.derivative);
  }
  if (!o.has("lowpass")) {
    if (!o.has("derivative"))
      throw Error({o.self().node->place, o.self().path, "the filter does nothing", described(*o.self().node),
                   "give derivative, lowpass, or numerator and denominator"});
    return difference_filter(d.sample_rate, d.derivative);
  }
  const Field lowpass = o.at("lowpass");
  if (lowpass.node->type != Node::Type::mapping)
    throw Error(lowpass.fault("must be a mapping", "write {family: first_order, order: 2, cutoff: 50 Hz}"));
  const FilterFamily& family = family_of(lowpass);
  std::vector<Parameter> format = spec_format::lowpass();
  format.insert(format.end(), family.parameters.begin(), family.parameters.end());
  const Object parameters(lowpass, format);
  d.numbers = parameters.numbers(family.parameters);
  d.choices = parameters.choices(family.parameters);
  return family.design(d);
}

/// Rates hundreds of orders of magnitude apart leave the range of a double: that is the spec's fault, not
/// qerr's.
Norms norms_of(const Filter& filter) {
  const auto out_of_range = [](const std::string& found) {
    return Error({{},
                  "",
                  "the filter's figures leave the range of double precision",
                  found,
                  "bring cut-off and sample rate closer together"});
  };
  Norms n;
  try {
    n = norms(filter);
  } catch (const Error& e) {
    throw out_of_range(e.faults().front().found);
  }
  if (!std::isfinite(n.h2) || !std::isfinite(n.l1.upper) || !std::isfinite(n.dc_gain))
    throw out_of_range("H2 norm " + shortest(n.h2));
  return n;
}

/// The designers speak of their own parameters; this puts file, line and path before what they say.
Error placed(const Error& e, const Field& f) {
  std::vector<Fault> faults = e.faults();
  for (Fault& fault : faults) {
    if (!fault.place.file.empty()) continue;
    const Node* lowpass = f.node->find("lowpass");
    for (const Node* holder : {f.node, lowpass})
      if (const Node* value = holder ? holder->find(fault.key) : nullptr) {
        fault.place = value->place;
        fault.key = f.path + (holder == lowpass ? ".lowpass." : ".") + fault.key;
        break;
      }
    if (fault.place.file.empty()) {
      fault.place = f.node->place;
      fault.key = f.path + (fault.key.empty() ? "" : '.' + fault.key);
    }
  }
  return Error(faults, e.trouble());
}

}  // namespace

void read_filters(const Field& f, Spec& spec, Faults& faults) {
  for (const auto& entry : read_map(f)) {
    const Node::Key& key = entry.first;
    const Field& field = entry.second;
    faults.guard([&] {
      if (key.name == "position" || key.name.empty())
        throw Error({key.place, field.path, "the name is taken: 'position' is the unfiltered coordinate",
                     "'" + key.name + "'", "choose another name"});
      const Object o(field, spec_format::filter());
      try {
        const Filter filter = design(o);
        spec.filters.push_back({key.name, filter, norms_of(filter)});
      } catch (const Error& e) {
        throw placed(e, field);
      }
    });
  }
}

}  // namespace qerr
