#include <algorithm>

#include "qerr/core/quantity.hpp"
#include "qerr/report/plan_report.hpp"
#include "report/json_value.hpp"

namespace qerr {

namespace {

std::string joint_motion_text(const JointMotion& m) {
  std::string out = "{center: " + shortest(m.center);
  if (m.velocity != 0) out += ", velocity: " + shortest(m.velocity);
  if (!m.sines.empty()) {
    out += ", sines: [";
    for (const Sine& s : m.sines)
      out += (&s == &m.sines.front() ? "{amplitude: " : ", {amplitude: ") + shortest(s.amplitude) +
             ", frequency: " + shortest(s.frequency) + (s.phase != 0 ? ", phase: " + shortest(s.phase) : "") +
             '}';
    out += ']';
  }
  if (!m.moves.empty()) {
    out += ", moves: [";
    for (const Move& x : m.moves)
      out += std::string(&x == &m.moves.front() ? "" : ",") + "\n      {to: " + shortest(x.to) +
             ", velocity: " + shortest(x.velocity) + ", acceleration: " + shortest(x.acceleration) +
             (x.jerk > 0 ? ", jerk: " + shortest(x.jerk) : "") + ", dwell: " + shortest(x.dwell) + '}';
    out += ']';
  }
  return out + '}';
}

/// A name as a key of YAML: in quotes unless it is plain.
std::string key_text(const std::string& name) {
  const bool plain = !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  }) && !(name[0] >= '0' && name[0] <= '9');
  return plain ? name : Json(name).line();
}

}  // namespace

std::string motion_text(const Motion& m, const Chain& chain) {
  std::string out = "motion:\n  sample_rate: " + shortest(m.sample_rate) +
                    " Hz\n  duration: " + shortest(m.duration) + " s\n";
  if (m.settling) out += "  settling: " + shortest(*m.settling) + " s\n";
  out += "  joints:\n";
  for (std::size_t j = 0; j < m.joints.size(); ++j)
    out += "    " + key_text(chain.independent[j].name) + ": " + joint_motion_text(m.joints[j]) + '\n';
  return out;
}

}  // namespace qerr
