#include "report/output_schemas.hpp"

namespace qerr {

namespace {

Json urdf_joint_schema() {
  using namespace schema;
  const Json mimic = object({{"joint", text()}, {"multiplier", number()}, {"offset", number()}});
  return object({{"name", text()},
                 {"type", text()},
                 {"parent", text()},
                 {"child", text()},
                 {"unit", one_of({"m", "rad"}), "of a moving joint, as the members below", true},
                 {"axis", list(number()), "in the frame of the joint", true},
                 {"limits", or_null(interval()), "null: none", true},
                 {"effort", number_or_null(), "", true},
                 {"velocity", number_or_null(), "", true},
                 {"ratio", number_or_null(), "that the URDF states", true},
                 {"mimic", or_null(mimic), "", true}});
}

}  // namespace

Json robot_schema() {
  using namespace schema;
  const Json end = object({{"tip", text()},
                           {"base", text()},
                           {"moving_joints", number()},
                           {"kind", text()},
                           {"joints", list(text())}});
  const Json flaw = object({{"severity", one_of({"error", "warning"})}, {"message", text()}});
  const Json coupling = object({{"transmission", text()},
                                {"type", text()},
                                {"joints", list(text())},
                                {"ratios", list(number()), "of the two motors"},
                                {"coupling", list(list(number())), "joints = coupling * (motors / ratios)"}});
  return object(
      {{"qerr", text(), "the version that wrote the report"},
       {"command", constant("robot")},
       {"urdf", object({{"file", text()}, {"sha256", text()}})},
       {"robot", object({{"name", text()}, {"roots", list(text())}})},
       {"first_spec", or_null(object({{"base", text()}, {"tip", text()}})), "the chain of --write-spec"},
       {"links", list(text())},
       {"joints", list(urdf_joint_schema())},
       {"couplings", list(coupling), "of two motors and two joints"},
       {"ends", list(end), "of the tree, the likeliest tip first"},
       {"flaws", list(flaw)}});
}

}  // namespace qerr
