#include <array>
#include <cmath>

#include "core/text.hpp"
#include "report/diagnosis/parts.hpp"
#include "report/diagnosis/sections.hpp"

namespace qerr {

namespace {

/// What the words are made of.
struct FoundShape {
  const Spec& spec;
  const Unidentified& found;

  std::string unit() const { return coordinate_unit(spec, found.joint); }
  bool has(const std::string& figure) const { return found.figures.contains(figure); }
  double figure(const std::string& name) const { return found.figures.at(name); }
  std::string size(double value) const { return size_text(value, unit(), encoder_of(spec, found.joint)); }

  /// `prefix` and the figure, "" without it.
  std::string with(const std::string& prefix, const std::string& name) const {
    if (!has(name)) return "";
    return prefix + (figure_unit(spec, found, name) == "rad"
                         ? size_text(figure(name), "rad", nullptr)
                         : readable(figure(name), figure_unit(spec, found, name)));
  }
  std::string of_amplitude(const std::string& prefix) const {
    return found.amplitude > 0 ? prefix + size(found.amplitude) : "";
  }
  std::string order_text() const {
    const double order = has("order") ? figure("order") : found.order.value_or(0);
    return significant(order, 4) + (unit() == "m" ? " per metre" : " per revolution of the joint");
  }
};

/// Mains are within 1 % of 50 Hz for 99.5 % of a year (EN 50160), and better at 60 Hz; rectifiers double it.
std::string mains(double frequency) {
  for (const double grid : {50.0, 60.0})
    for (const double multiple : {1.0, 2.0})
      if (std::abs(frequency - multiple * grid) <= 0.01 * multiple * grid)
        return multiple == 1 ? " (mains)" : " (twice mains)";
  return "";
}

std::string step_words(const FoundShape& r) {
  const std::string of_size =
      r.has("size") ? " of " + r.size(std::abs(r.figure("size"))) : r.of_amplitude(" of ");
  return "a step" + of_size + r.with(" at ", "time");
}

std::string hysteresis_words(const FoundShape& r) {
  const std::string width = r.has("width") ? " of " + r.size(r.figure("width")) : r.of_amplitude(" of ");
  return "hysteresis" + width + r.with(" over ", "travel") + " after each reversal";
}

std::string exponential_words(const FoundShape& r) {
  return "an exponential after stops" + r.of_amplitude(" of ") + r.with(", time constant ", "time_constant");
}

std::string line_words(const FoundShape& r) {
  const double frequency = r.has("frequency") ? r.figure("frequency") : r.found.frequency.value_or(0);
  return "a line at " + readable(frequency, "Hz") + mains(frequency) + r.of_amplitude(", amplitude ");
}

std::string order_words(const FoundShape& r) {
  return "a sine of order " + r.order_text() + r.of_amplitude(", amplitude ");
}

std::string bump_words(const FoundShape& r) {
  return "a bump" + r.of_amplitude(" of ") + r.with(" at ", "angle") + r.with(", width ", "width");
}

std::string count_words(const FoundShape& r) {
  return "an error that repeats every " +
         (r.has("divisor") ? significant(r.figure("divisor"), 4) + " counts" : "few counts") +
         r.of_amplitude(", amplitude ");
}

std::string noise_words(const FoundShape& r) { return "scatter from row to row" + r.of_amplitude(" of "); }

std::string unknown_words(const FoundShape& r) {
  std::string text = escaped(r.found.what);
  if (r.found.order && *r.found.order > 0) text += ", order " + r.order_text();
  if (r.found.frequency) text += ", " + readable(*r.found.frequency, "Hz");
  return text + r.of_amplitude(", amplitude ");
}

struct ShapeRow {
  Shape shape;
  std::string (*words)(const FoundShape&);
  std::string_view next;  ///< what to inspect or to record
};

constexpr std::array<ShapeRow, 9> shape_rows{{
    {Shape::step, step_words, "look for a slip, a collision or a restart at that time, and record again"},
    {Shape::hysteresis, hysteresis_words,
     "record slow reversals with two loads: friction with a soft drive grows with the load, play does not"},
    {Shape::exponential, exponential_words,
     "record stops of five time constants or more, from two speeds, and the controller's command"},
    {Shape::line, line_words,
     "record with the drives off, then on and at rest: what remains is electrical or comes through the "
     "floor"},
    {Shape::order, order_words,
     "compare the order with the teeth, shafts and bearings of the drive; record at another speed"},
    {Shape::bump, bump_words,
     "inspect scale, track or teeth at that angle; record a second passage in either direction"},
    {Shape::by_count, count_words,
     "record one slow revolution, and inspect offset, gain and phase of the encoder's signals"},
    {Shape::noise, noise_words, "record at rest with the drives off, then on: the difference is theirs"},
    {Shape::unknown, unknown_words,
     "record load and temperature too, with reversals at two speeds and a rest after each"},
}};

const ShapeRow& row_of(Shape shape) {
  for (const ShapeRow& row : shape_rows)
    if (row.shape == shape) return row;
  return shape_rows.back();
}

}  // namespace

std::string shape_words(const Spec& spec, const Unidentified& u) { return row_of(u.shape).words({spec, u}); }

std::string shape_advice(Shape shape) { return std::string(row_of(shape).next); }

}  // namespace qerr
