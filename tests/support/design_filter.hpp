#pragma once

#include <gtest/gtest.h>

#include <stdexcept>
#include <string_view>

#include "qerr/core/error.hpp"
#include "qerr/filter/family.hpp"

namespace qerr {

/// Back differences and a low-pass of a family, with the family's defaults except for order and cut-off.
inline Filter design_filter(std::string_view name, int derivative, double rate, double order, double cutoff) {
  for (const FilterFamily& family : filter_families())
    if (family.name == name)
      return family.design({derivative, rate, {{"order", order}, {"cutoff", cutoff}}, {}, {}});
  throw std::runtime_error("no such family");
}

/// The paper's cascade at 1 kHz, matched poles.
inline Filter cascade(int derivative, int order, double cutoff = 50) {
  return design_filter("first_order", derivative, 1000, order, cutoff);
}

/// The first fault of the error that the action throws; a test failure if it throws none.
template <typename Action>
Fault refusal(Action action) {
  try {
    action();
  } catch (const Error& error) {
    return error.faults().at(0);
  }
  ADD_FAILURE() << "no error";
  return {};
}

}  // namespace qerr
