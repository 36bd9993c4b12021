#pragma once

#include <string>
#include <vector>

/// Axes of pictures.
namespace qerr::page {

/// What an axis shows.
struct AxisRange {
  std::string label;      ///< the quantity
  std::string unit = {};  ///< SI, without a prefix; "" for a pure number
  bool logarithmic = false;
  bool prefix = true;  ///< on a linear axis: an SI prefix by the size of the values
};

struct Tick {
  double value = 0;   ///< [SI]
  std::string label;  ///< in the unit of the axis' title
};

struct Axis {
  std::string title;  ///< quantity and unit with its SI prefix: `gain [krad/s]`
  bool logarithmic = false;
  double from = 0, to = 1;  ///< [SI]
  std::vector<Tick> ticks;

  /// Where a value lies: 0 at `from`, 1 at `to`.
  double part(double value) const;
};

/// An axis from a tick at or below `least` to one at or above `largest`, with round ticks: 1, 2 or 5 times a
/// power of ten, or powers of ten on a logarithmic axis (1, 2, 5 of each where it has less than two decades).
/// @param most  ticks, about
/// @pre finite values; on a logarithmic axis above 0
Axis axis(const AxisRange&, double least, double largest, int most = 6);

}  // namespace qerr::page
