#include <cmath>

#include "core/number_advice.hpp"
#include "input/read_sections.hpp"
#include "input/spec_format.hpp"

namespace qerr {

namespace {

Quantity end_of_range(const Object& o, const std::string& key) {
  if (!o.has(key))
    throw Error({o.self().node->place, o.self().path + '.' + key, "missing key", "",
                 "give values: [...], or from, to and count"});
  const Field f = o.at(key);
  std::string why = "must be a number";
  const auto quantity = f.node->type == Node::Type::scalar ? parse_quantity(f.node->text, why) : std::nullopt;
  if (!quantity) {
    const NumberAdvice advice = advice_on_number(f.node->text, why);
    throw Error(f.fault(advice.rule,
                        advice.remedy.empty() ? "a number, with a unit if the key has one" : advice.remedy));
  }
  return *quantity;
}

std::vector<std::string> range_values(const Object& o) {
  const Quantity from = end_of_range(o, "from"), to = end_of_range(o, "to");
  if (from.dimension != to.dimension)
    throw Error(o.at("to").fault("must have the same kind of unit as 'from'", "give both in the same unit"));
  const auto count = o.number("count");
  if (!count)
    throw Error({o.self().node->place, o.self().path + ".count", "missing key", "", "add 'count: ...'"});
  const bool log = o.choice("scale") == "log";
  if (log && !(from.value > 0 && to.value > 0))
    throw Error(o.at("scale").fault("a logarithmic range must have positive ends", "use scale: linear"));
  const std::string unit = from.dimension ? " " + unit_name(*from.dimension) : "";
  std::vector<std::string> values;
  for (int i = 0; i < static_cast<int>(*count); ++i) {
    const double t = i / (*count - 1);
    const double value = i == 0   ? from.value
                         : t == 1 ? to.value
                         : log    ? from.value * std::pow(to.value / from.value, t)
                                  : from.value + t * (to.value - from.value);
    values.push_back(shortest(value) + unit);
  }
  return values;
}

}  // namespace

void read_sweep(const Field& f, Spec& spec, Faults& faults) {
  for (const Field& item : read_list(f, "a list: - {key: ..., values: [...]}"))
    faults.guard([&] {
      const Object o(item, spec_format::sweep());
      SweepAxis axis{*o.text("key"), {}};
      if (o.has("values")) {
        for (const char* key : {"from", "to", "count", "scale"})
          if (o.has(key))
            throw Error(o.at(key).fault("cannot be combined with 'values'", "keep one of the two"));
        for (const Field& value : read_list(o.at("values"), "[13, 15, 17]")) {
          if (value.node->type != Node::Type::scalar)
            throw Error(value.fault("must be a single value", "a number, word or quantity"));
          axis.values.push_back(value.node->text);
        }
        if (axis.values.empty())
          throw Error(o.at("values").fault("the list is empty", "give at least one value"));
      } else {
        axis.values = range_values(o);
      }
      spec.sweep.push_back(axis);
    });
}

}  // namespace qerr
