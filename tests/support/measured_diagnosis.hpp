#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "qerr/diagnose/diagnosis.hpp"
#include "support/measured.hpp"

namespace qerr::testing {

/// The verdict and the names of all that was found.
inline std::string said(const Diagnosis& d) {
  std::string text(name(d.verdict));
  for (const Cause& c : d.causes) text += " + " + c.effect.type + " at " + c.effect.joint;
  for (const AlternativeCause& a : d.alternatives)
    text += " or " + a.effect + " at " + a.joint + " for " + a.instead_of;
  for (const Unidentified& u : d.unexplained) text += " + unexplained at " + u.joint + ": " + u.what;
  std::replace(text.begin(), text.end(), ',', ';');
  return text;
}

/// A text of the report, with the number signs of a figure in place of its digits: those are compared by
/// themselves.
inline std::string without_digits(std::string text) {
  std::replace(text.begin(), text.end(), ',', ';');
  std::replace_if(
      text.begin(), text.end(), [](char c) { return '0' <= c && c <= '9'; }, '#');
  return text;
}

/// Sum of magnitudes of what is known.
inline double total(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values)
    if (std::isfinite(v)) sum += std::abs(v);
  return sum;
}

/// Compares all figures; the tolerance is that of the fits' last steps, which may differ between compilers.
inline void expect_as_measured(const std::string& record, const Diagnosis& d) {
  static const Measured measured("diagnoses.csv", 1e-3);
  std::map<std::string, int> met;  // two parts of a residual may have one name
  const auto expect = [&](const std::string& what, double value) {
    // Intervals of a tracked tip follow the autocorrelation of its residual, and that the readings near an
    // edge, which the last digit of a sine moves: two processors differed by 5 %, and by 14 % in one log p.
    const bool of_edges =
        record.starts_with("arm ") && (what.ends_with("half width") || what.ends_with("log p"));
    const int times = ++met[what];
    measured.expect(record + ',' + what + (times > 1 ? " no " + std::to_string(times) : ""), value,
                    of_edges ? std::optional(0.2) : std::nullopt);
  };
  const auto expect_gain = [&](const std::string& of, const Gain& g) {
    expect(of + " rms before", g.rms_before);
    expect(of + " rms after", g.rms_after);
    expect(of + " lower ratio", g.lower);
    expect(of + " upper ratio", g.upper);
    expect(of + " sigma ratio", g.sigma_ratio);
    expect(of + " log score", g.log_score);
    expect(of + " coverage", g.coverage);
  };
  expect(said(d), static_cast<double>(d.causes.size()));
  for (const Cause& c : d.causes) {
    for (const FoundParameter& p : c.parameters) {
      expect(c.effect.type + ' ' + p.name, p.value);
      expect(c.effect.type + ' ' + p.name + " half width", 0.5 * (p.upper - p.lower));
    }
    expect(c.effect.type + " log p", std::log(std::max(c.p_value, 1e-300)));
    expect(c.effect.type + " rms", c.rms);
    expect(c.effect.type + " rms without", c.rms_without);
    expect_gain(c.effect.type, c.gain);
  }
  for (const Unidentified& u : d.unexplained) {
    expect(u.what + " amplitude", u.amplitude);
    if (u.order) expect(u.what + " order", *u.order);
    if (u.frequency) expect(u.what + " frequency", *u.frequency);
    for (const auto& [figure, value] : u.figures) expect(u.what + ' ' + figure, value);
  }
  const auto expect_text = [&](const std::string& what, const std::string& text) {
    if (!text.empty()) expect(what + ": " + without_digits(text), 1);
  };
  const auto expect_curve = [&](const std::string& of, const ResidualCurve& c) {
    if (c.at.empty()) return;
    expect(of + " against " + c.against, total(c.at));
    expect(of + " residual", total(c.residual));
    expect(of + " fit", total(c.fit));
  };
  for (const Cause& c : d.causes) expect_curve(c.effect.type, c.curve);
  for (const Unidentified& u : d.unexplained) {
    expect_curve(u.what, u.curve);
    expect_text("next", u.next);
  }
  for (const AlternativeCause& a : d.alternatives) expect_text("record", a.record);
  for (const Visible& v : d.visible) {
    expect("visible " + v.effect + " at " + v.joint, v.smallest);
    expect_text("hidden by", v.hidden_by);
  }
  for (const Comparison& c : d.simulation) expect("observed " + c.statistic + " of " + c.joint, c.observed);
  for (const DataFinding& f : d.data) expect_text("data at " + f.joint, f.what + "; " + f.remedy);
  for (const std::string& warning : d.warnings) expect_text("warning", warning);
  expect_text("reason", d.reason);
  expect_gain("all", d.gain);
  measured.expect_all_met(record + ',');
}

}  // namespace qerr::testing
