#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "qerr/input/first_spec.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/kinematics/chain.hpp"

namespace qerr {
namespace {

constexpr double pi = std::numbers::pi;

/// A row as it is written in textbooks.
struct Row {
  double theta = 0, d = 0, a = 0, alpha = 0;
  int moves = 0;  // 1: theta, 2: d, 0: none
  double sign = 1;
};

/// The elementary transforms, element by element.
Eigen::Matrix4d about_z(double t) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m(0, 0) = m(1, 1) = std::cos(t), m(1, 0) = std::sin(t), m(0, 1) = -m(1, 0);
  return m;
}
Eigen::Matrix4d about_x(double t) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m(1, 1) = m(2, 2) = std::cos(t), m(2, 1) = std::sin(t), m(1, 2) = -m(2, 1);
  return m;
}
Eigen::Matrix4d along(int axis, double length) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m(axis, 3) = length;
  return m;
}

Eigen::Matrix4d product(const std::vector<Row>& rows, const std::vector<double>& q, bool modified) {
  Eigen::Matrix4d t = Eigen::Matrix4d::Identity();
  std::size_t next = 0;
  for (const Row& r : rows) {
    const double at = r.moves == 0 ? 0 : r.sign * q[next++];
    const double theta = r.theta + (r.moves == 1 ? at : 0), d = r.d + (r.moves == 2 ? at : 0);
    t *= modified ? about_x(r.alpha) * along(0, r.a) * about_z(theta) * along(2, d)
                  : about_z(theta) * along(2, d) * along(0, r.a) * about_x(r.alpha);
  }
  return t;
}

/// theta or d as a person writes it.
std::string entry(double constant, bool moves, double sign, int number, bool angle) {
  const std::string value = std::to_string(std::abs(constant)) + (angle ? " rad" : " m");
  if (!moves) return (constant < 0 ? "-" : "") + value;
  const std::string variable = (sign < 0 ? "-q" : "q") + std::to_string(number);
  return number % 2
             ? variable + (constant < 0 ? " - " : "+") + value
             : (constant < 0 ? "-" : "") + value + (sign < 0 ? " - q" : " + q") + std::to_string(number);
}

std::string table(const std::vector<Row>& rows, const std::string& convention) {
  std::string text = "qerr: 1\nrobot:\n  convention: " + convention + "\n  dh:\n";
  int joint = 0;
  for (const Row& r : rows) {
    if (r.moves) ++joint;
    text += "    - {theta: " + entry(r.theta, r.moves == 1, r.sign, joint, true) +
            ", d: " + entry(r.d, r.moves == 2, r.sign, joint, false) + ", a: " + std::to_string(r.a) +
            ", alpha: " + std::to_string(r.alpha) + "}\n";
  }
  return text + "encoders: {'*': {bits: 12}}\n";
}

double six_digits(double value) { return std::stod(std::to_string(value)); }

TEST(DhTable, IsTheProductOfItsTransforms) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> angle(-3, 3), length(-0.8, 0.8);
  for (int i = 0; i < 200; ++i) {
    std::vector<Row> rows(1 + random() % 7);
    for (Row& r : rows)
      r = {six_digits(angle(random)), six_digits(length(random)),     six_digits(length(random)),
           six_digits(angle(random)), static_cast<int>(random() % 3), random() % 2 ? 1.0 : -1.0};
    rows.front().moves = 1;
    const bool modified = i % 2;
    SCOPED_TRACE(table(rows, modified ? "modified" : "standard"));
    const Chain chain = robot_of_spec(table(rows, modified ? "modified" : "standard"), "arm.yaml").chain;
    Eigen::VectorXd q(static_cast<Eigen::Index>(chain.independent.size()));
    for (double& value : q) value = angle(random);
    const Eigen::Matrix4d expected = product(rows, {q.begin(), q.end()}, modified);
    EXPECT_LT((forward_kinematics(chain, q).matrix() - expected).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(DhTable, IsARobotForEveryCommand) {
  const Spec spec = parse_spec(
      "qerr: 1\nrobot: {dh: [{theta: q1, a: 300 mm, limits: [-pi/2, pi/2]}, {d: lift, limits: [0, 0.2]}]}\n"
      "encoders: {q1: {bits: 10}, lift: {resolution: 10 um}}\n",
      "press.yaml");
  EXPECT_EQ(spec.robot_name, "press");
  ASSERT_EQ(spec.model.chain.independent.size(), 2U);
  EXPECT_EQ(spec.model.chain.independent[0].limits->upper, pi / 2);
  EXPECT_TRUE(spec.model.chain.independent[1].prismatic());
}

std::string fault_of(const std::string& rows) {
  try {
    parse_spec("qerr: 1\nrobot: {dh: [" + rows + "]}\nencoders: {'*': {bits: 10}}\n", "arm.yaml");
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(DhTable, RefusesWhatIsNoTable) {
  EXPECT_NE(fault_of("{theta: q1, alpha: 90}").find("write 90 deg"), std::string::npos);
  EXPECT_NE(fault_of("{theta: q1, d: d1}").find("one variable"), std::string::npos);
  EXPECT_NE(fault_of("{theta: q1}, {theta: q1}").find("two rows have the variable 'q1'"), std::string::npos);
  EXPECT_NE(fault_of("{theta: q1 minus 3}").find("must be a quantity, or a joint's variable"),
            std::string::npos);
  EXPECT_NE(fault_of("{theta: 0, limits: [0, 1]}, {theta: q1}").find("nothing moves"), std::string::npos);
  EXPECT_NE(fault_of("{theta: 1 m}").find("theta"), std::string::npos);
}

TEST(DhTable, AsksForTheConventionWhereItLooksLikeTheOther) {
  const auto warned = [](const std::string& robot) {
    return robot_of_spec("qerr: 1\nrobot: {" + robot + "}\nencoders: {}\n", "a.yaml").warnings.size();
  };
  const std::string craig = "dh: [{theta: q1}, {theta: q2, a: 0.3, alpha: 90 deg}]";
  EXPECT_EQ(warned(craig), 1U);
  EXPECT_EQ(warned("convention: standard, " + craig), 0U);
  EXPECT_EQ(warned("dh: [{theta: q1, a: 0.3, alpha: 90 deg}, {theta: q2}]"), 0U);
}

}  // namespace
}  // namespace qerr
