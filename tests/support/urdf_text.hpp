#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "qerr/core/error.hpp"
#include "qerr/input/first_spec.hpp"

/// URDF documents of a few links, as text.
namespace qerr::testing::urdf {

inline const std::string limit = R"(<limit lower="-1" upper="2" effort="3" velocity="4"/>)";
inline const std::string links = R"(<link name="a"/><link name="b"/><link name="c"/>)";

inline std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                         const std::string& child, const std::string& inside = limit) {
  return "<joint name='" + name + "' type='" + type + "'><parent link='" + parent + "'/><child link='" +
         child + "'/>" + inside + "</joint>";
}

/// A robot whose line 2 holds `body`.
inline std::string robot(const std::string& body) { return "<robot name='r'>\n" + body + "\n</robot>\n"; }

/// Links a, b, c in a row; the first joint is revolute and has `inside` on line 3.
inline std::string inside_joint(const std::string& inside, const std::string& type = "revolute") {
  return robot(links + joint("ab", type, "a", "b", "\n" + inside + "\n") +
               joint("bc", "fixed", "b", "c", ""));
}

inline RobotModel read(const std::string& text) { return parse_urdf(text, "r.urdf"); }

/// The flaws of a document; those that spoil a part, or the others.
inline std::vector<Fault> flaws(const RobotModel& model, bool spoiling) {
  std::vector<Fault> faults;
  for (const Flaw& flaw : model.flaws)
    if (flaw.spoils == spoiling) faults.push_back(flaw.fault);
  return faults;
}

inline std::vector<std::string> warnings(const RobotModel& model) {
  std::vector<std::string> texts;
  for (const Fault& fault : flaws(model, false)) texts.push_back(format({fault}));
  return texts;
}

/// Reads a robot of which every part is used.
inline RobotModel read_strictly(const std::string& text) {
  RobotModel model = read(text);
  if (const std::vector<Fault> faults = flaws(model, true); !faults.empty()) throw Error(faults);
  return model;
}

inline std::string refusal(const std::string& text) {
  try {
    read_strictly(text);
  } catch (const Error& e) {
    EXPECT_EQ(e.trouble(), Trouble::input);
    return e.what();
  }
  return "accepted";
}

}  // namespace qerr::testing::urdf
