#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/text.hpp"
#include "report/diagnosis/parts.hpp"
#include "report/diagnosis/sections.hpp"
#include "report/text_picture.hpp"

namespace qerr {

namespace {

constexpr double degree = std::numbers::pi / 180;

/// A scale of an axis, and its name.
struct AxisUnit {
  double factor = 1;  ///< of the unit shown, in SI units
  std::string name;
};

double largest(const std::vector<double>& values) {
  double most = 0;
  for (const double value : values)
    if (std::isfinite(value)) most = std::max(most, std::abs(value));
  return most;
}

AxisUnit axis_unit(const std::vector<double>& values, const std::string& unit) {
  if (unit == "rad") return {degree, "deg"};
  if (unit == "rad/s") return {degree, "deg/s"};
  if (unit.empty() || unit.starts_with("count")) return {1, unit};
  const PrefixedUnit prefix = prefixed(largest(values), unit);
  return {prefix.factor, prefix.unit};
}

std::vector<double> divided(std::vector<double> values, double factor) {
  for (double& value : values) value /= factor;
  return values;
}

}  // namespace

void add_once(std::vector<std::string>& list, const std::string& item) {
  if (std::find(list.begin(), list.end(), item) == list.end()) list.push_back(item);
}

std::string arc_text(double angle) {
  const double size = std::abs(angle) / degree;
  if (size >= 1) return significant(angle / degree, 3) + " deg";
  if (size >= 1.0 / 60) return significant(angle / degree * 60, 3) + " arcmin";
  return significant(angle / degree * 3600, 3) + " arcsec";
}

std::string size_text(double value, const std::string& unit, const Encoder* encoder) {
  std::string text = encoder ? significant(value / encoder->resolution, 3) + " counts = " : "";
  text += readable(value, unit);
  return unit == "rad" ? text + " = " + arc_text(value) : text;
}

std::string curve_picture(const Spec& spec, const std::string& joint, const ResidualCurve& curve,
                          const Style& style) {
  if (curve.at.empty()) return "";
  const Encoder* encoder = encoder_of(spec, joint);
  std::vector<double> values = curve.residual;
  values.insert(values.end(), curve.fit.begin(), curve.fit.end());
  const PrefixedUnit prefix = prefixed(largest(values), coordinate_unit(spec, joint));
  const AxisUnit x = axis_unit(curve.at, curve.unit);
  const AxisUnit y = encoder ? AxisUnit{encoder->resolution, "counts"} : AxisUnit{prefix.factor, prefix.unit};
  return text_picture({divided(curve.at, x.factor), divided(curve.residual, y.factor),
                       divided(curve.fit, y.factor), curve.fit.empty() ? "residual" : "residual without this",
                       "fit", y.name, curve.against + (x.name.empty() ? "" : " [" + x.name + "]")},
                      style);
}

}  // namespace qerr
