#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "diagnose/inference/tip/tip.hpp"
#include "support/measured_texts.hpp"
#include "support/tracked_arm.hpp"

/// What is said of tracked arms: the warnings, what is unexplained, and what to record.
namespace qerr {
namespace {

using testing::Arm;
using testing::Dice;
using testing::MeasuredTexts;
using testing::Record;

struct SpokenRecord {
  Arm arm, built;
  Record record;
  std::function<Eigen::Vector3d(const Eigen::Vector3d&)> seen = [](const Eigen::Vector3d& p) { return p; };
};

std::string spoken(const TipDiagnosis& d) {
  std::string text = d.judged ? "" : "not judged";
  for (const Cause& c : d.causes) text += "cause " + c.effect.type + " at " + c.effect.joint + "; ";
  for (const Unidentified& u : d.unexplained)
    text += "unexplained at " + u.joint + ", " + u.what + ", " + u.next + "; ";
  for (const AlternativeCause& a : d.alternatives)
    text += a.effect + " at " + a.joint + " for " + a.instead_of + ", " + a.record + "; ";
  for (const std::string& w : d.warnings) text += "warning " + w + "; ";
  return text.empty() ? "nothing" : text;
}

TEST(TipTexts, AreAsMeasured) {
  const double step = 2e-4;
  const std::vector<std::pair<const char*, std::function<void(Dice&, SpokenRecord&)>>> records{
      {"nothing", [](Dice&, SpokenRecord&) {}},
      {"longer tool", [](Dice&, SpokenRecord& r) { r.built.tool += Eigen::Vector3d(3e-3, 2e-4, 0); }},
      {"target beside the tip",
       [](Dice&, SpokenRecord& r) { r.built.tool += Eigen::Vector3d(-1e-3, 2e-3, 4e-3); }},
      {"target beside one axis",
       [](Dice&, SpokenRecord& r) { r.built.tool += Eigen::Vector3d(0, -5e-3, 1e-4); }},
      {"tracker elsewhere",
       [](Dice&, SpokenRecord& r) {
         const Eigen::Matrix3d turned = testing::rotation(Eigen::Vector3d(0.6, 0, 0.8), 3e-3);
         r.seen = [turned](const Eigen::Vector3d& p) -> Eigen::Vector3d {
           return turned * p + Eigen::Vector3d(2e-3, -1e-3, 3e-3);
         };
       }},
      {"displaced base", [](Dice&, SpokenRecord& r) { r.built.place[0].x() += 1e-3; }},
      {"displaced joint", [](Dice&, SpokenRecord& r) { r.built.place[1].x() += 1e-3; }},
      {"offset over a short arc",
       [=](Dice&, SpokenRecord& r) {
         r.record.joints *= 0.05;
         r.record.additions.row(1).setConstant(6 * step);
       }},
      {"skew axis",
       [](Dice&, SpokenRecord& r) {
         r.built.axis[1] = testing::rotation(Eigen::Vector3d::UnitX(), 5e-3) * r.built.axis[1];
       }},
      {"scale along a motion",
       [=](Dice& dice, SpokenRecord& r) {
         r.record = testing::motion(dice, 3, 300);
         r.record.joints *= 0.1;
         r.record.additions.row(1) = 60 * step * r.record.joints.row(1);
       }},
      {"too short", [](Dice& dice, SpokenRecord& r) { r.record = testing::poses(dice, 3, 7); }},
      {"short", [](Dice& dice, SpokenRecord& r) { r.record = testing::poses(dice, 3, 8); }},
  };
  const MeasuredTexts texts("tip_texts.txt");
  std::uint64_t seed = 0;
  for (const auto& [name, change] : records) {
    Dice dice(7000 + ++seed);
    SpokenRecord r;
    r.arm = r.built = testing::random_arm(dice, 3);
    r.record = testing::poses(dice, 3, 80);
    change(dice, r);
    const std::vector<double> resolution(3, step);
    const Log log = testing::log_of(dice, r.built, r.record, resolution, 1e-5, r.seen);
    texts.expect(name, spoken(diagnose_tip(r.arm.model(resolution), {}, log, 1, 1)));
  }
}

}  // namespace
}  // namespace qerr
