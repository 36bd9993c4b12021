#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "input/spec_variants.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// Variants whose number is `first` modulo `stride`: shard K of N has first K - 1 and stride N, so that each
/// has its share of every part of the grid.
struct Shard {
  std::uint64_t first = 0, stride = 1;

  std::uint64_t variant(std::uint64_t index) const { return first + index * stride; }
  /// How many of `total` variants it has.
  std::uint64_t size(std::uint64_t total) const {
    return total > first ? (total - first - 1) / stride + 1 : 0;
  }
};

/// A key that varies, as programs read it.
struct SweepColumn {
  std::string key, unit;
  std::size_t axis = 0;
  /// Of the steps of its axis [SI], if all of them are numbers, in units of one kind; else empty: they are
  /// texts, such as the family of a filter or a row of a catalogue.
  std::vector<double> values;

  /// The key, with its unit in brackets if it has one.
  std::string header() const { return unit.empty() ? key : key + " [" + unit + ']'; }
};

/// The variants of a sweep, numbered from 0: all combinations of the steps of its axes, of which the first
/// one varies slowest.
class SweepGrid {
 public:
  /// @throws Error (input; key `sweep`) if there is no axis, or more than 2^53 variants
  explicit SweepGrid(const Spec&);

  std::uint64_t count() const { return count_; }
  const std::vector<SweepAxis>& axes() const { return axes_; }

  /// The keys that vary, in the order of the axes.
  std::vector<std::string> keys() const;
  const std::vector<SweepColumn>& columns() const { return columns_; }
  /// The values of the keys, as reports name them.
  std::vector<std::string> names(std::uint64_t variant) const;
  /// `KEY = VALUE, KEY = VALUE` for messages. @param text  of a value's name
  std::string description(std::uint64_t variant,
                          const std::function<std::string(const std::string&)>& text = std::identity()) const;

  /// The step of each axis in a variant.
  std::vector<std::size_t> steps(std::uint64_t variant) const;
  /// The spec with the chosen steps of the axes. @param steps  as of `steps`
  Spec spec(const SpecVariants&, const std::vector<std::size_t>& steps) const;
  /// Likewise; empty if it has a fault.
  std::optional<Spec> readable(const SpecVariants&, const std::vector<std::size_t>& steps) const;

 private:
  /// A step as changes of the tree.
  struct Changes {
    std::vector<SpecChange> values;
    std::vector<Node> effects;
  };

  std::vector<SweepAxis> axes_;
  std::vector<SweepColumn> columns_;
  std::vector<std::vector<Changes>> changes_;  // [axis][step]
  std::uint64_t count_ = 1;
};

}  // namespace qerr
