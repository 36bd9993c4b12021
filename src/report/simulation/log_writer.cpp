#include <algorithm>
#include <array>
#include <charconv>

#include "kinematics/inverse_dynamics.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/report/simulation_report.hpp"
#include "report/csv_text.hpp"

namespace qerr {

namespace {

void append(std::string& text, double value) {
  std::array<char, 32> buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value == 0 ? 0.0 : value);
  text.append(buffer.data(), end.ptr);
}

void append_count(std::string& text, double count) {
  std::array<char, 32> buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), static_cast<long long>(count));
  text.append(buffer.data(), end.ptr);
}

}  // namespace

LogWriter::LogWriter(const Spec& spec) : spec_(spec), efforts_(has_masses(spec.model.chain)) {
  for (const IndependentJoint& joint : spec.model.chain.independent)
    rounded_.push_back(std::any_of(spec.effects.begin(), spec.effects.end(), [&](const Effect& e) {
      return e.joint == joint.name && effect_kind(e.type).stage == Stage::log && e.number("step") > 0;
    }));
  // Without the counts of one encoder, positions are recorded of every joint that it moves.
  const Coupling& coupling = spec.model.transmission.coupling;
  for (bool more = !coupling.is_identity(); more;) {
    more = false;
    for (Eigen::Index j = 0; j < coupling.size(); ++j)
      for (Eigen::Index i = 0; i < coupling.size(); ++i) {
        const auto joint = static_cast<std::size_t>(j), encoder = static_cast<std::size_t>(i);
        if (coupling(j, i) == 0 || !rounded_[encoder] || rounded_[joint]) continue;
        rounded_[joint] = more = true;
      }
  }
}

std::string LogWriter::header() const {
  std::string text = "time [s]";
  for (std::size_t i = 0; i < rounded_.size(); ++i) {
    const IndependentJoint& joint = spec_.model.chain.independent[i];
    const std::string unit = joint.prismatic() ? " [m]" : " [rad]";
    text += ',' + csv_cell(joint.name + (rounded_[i] ? ".measured" + unit : ".counts")) + ',' +
            csv_cell(joint.name + ".reference" + unit);
    if (efforts_) text += ',' + csv_cell(joint.name + (joint.prismatic() ? ".effort [N]" : ".effort [N m]"));
  }
  return text + ",tip.x [m],tip.y [m],tip.z [m]\r\n";
}

std::string_view LogWriter::row(const Reading& r) {
  text_.clear();
  append(text_, r.time);
  for (std::size_t i = 0; i < rounded_.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    text_ += ',';
    if (rounded_[i])
      append(text_, r.logged[row]);
    else
      append_count(text_, r.counts[row]);
    text_ += ',';
    append(text_, r.reference[row]);
    if (!efforts_) continue;
    text_ += ',';
    append(text_, r.effort[row]);
  }
  for (Eigen::Index i = 0; i < 3; ++i) {
    text_ += ',';
    append(text_, r.tip.translation()[i]);
  }
  text_ += "\r\n";
  return text_;
}

}  // namespace qerr
