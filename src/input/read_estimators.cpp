#include <algorithm>

#include "core/lists.hpp"
#include "core/suggest.hpp"
#include "core/text.hpp"
#include "input/joint_entries.hpp"
#include "input/read_sections.hpp"
#include "input/spec_format.hpp"
#include "simulate/estimators/estimator.hpp"

/// Reads the section `estimators` of a spec.
namespace qerr {

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
