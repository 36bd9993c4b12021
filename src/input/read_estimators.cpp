#include <algorithm>

#include "core/suggest.hpp"
#include "input/joint_entries.hpp"
#include "input/read_sections.hpp"
#include "input/spec_format.hpp"
#include "simulate/estimators/estimator.hpp"

/// Reads the section `estimators` of a spec.
namespace qerr {

namespace {

const EstimatorKind& kind_of(const Field& f) {
  std::vector<std::string> known;
  for (const EstimatorKind& kind : estimator_kinds()) known.emplace_back(kind.name);
  const Node* name = f.node->type == Node::Type::mapping ? f.node->find("kind") : nullptr;
  if (!name)
    throw Error({f.node->place, f.path_of("kind"), "missing key", "",
                 "add 'kind: ...' (" + did_you_mean("", known) + ")"});
  const Field field{name, f.path_of("kind")};
  const std::string text = read_text_value(field);
  if (std::find(known.begin(), known.end(), text) != known.end()) return estimator_kind(text);
  const bool family = std::any_of(filter_families().begin(), filter_families().end(),
                                  [&](const FilterFamily& filter) { return filter.name == text; });
  throw Error(field.fault("no such estimator", family ? "write it in filters: {" + text +
                                                            ": {derivative: 1, lowpass: {family: " + text +
                                                            "}}}: it is a linear filter"
                                                      : did_you_mean(text, known)));
}

}  // namespace

void read_estimators(const Field& f, const RobotModel& robot, Spec& spec, Faults& faults) {
  for (const auto& [key, field] : read_map(f)) {
    const auto& name = key;
    const Field& entry = field;
    faults.guard([&] {
      const EstimatorKind& kind = kind_of(entry);
      if (std::any_of(spec.filters.begin(), spec.filters.end(),
                      [&](const NamedFilter& other) { return other.name == name.name; }))
        throw Error({name.place, entry.path, "a filter has the same name", quoted(name.name),
                     "choose another name: reports have both in one table"});
      std::vector<Parameter> format = spec_format::estimator();
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
