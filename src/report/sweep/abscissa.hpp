#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "report/sweep/grid.hpp"

namespace qerr {

/// The key of a sweep whose values are numbers of one dimension: what figures are drawn over.
struct SweepAbscissa {
  std::size_t axis = 0;
  std::string key, unit;
  std::vector<double> values;      ///< of the axis' steps [SI]
  std::vector<std::size_t> order;  ///< steps by ascending value
  bool logarithmic = false;        ///< equally spaced in the logarithm
};

/// Of the first axis that has such a key, with two values at least; empty: there is none.
std::optional<SweepAbscissa> abscissa_of(const SweepGrid&);

/// A value of a key for people: a number of many digits, such as the steps of a logarithmic range have, with
/// six of them.
std::string short_value(const std::string& name);

/// `most` of `count` numbers from 0 on, evenly spread, the first and the last one among them.
std::vector<std::size_t> evenly_chosen(std::size_t count, std::size_t most);

}  // namespace qerr
