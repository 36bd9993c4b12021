#pragma once

#include <string>

#include "design/choice_figure.hpp"

namespace qerr {

/// The options that a search still permits: [options of all joints].
using PermittedOptions = std::vector<char>;

/// Configurations of a figure of a percentile at which choices have failed, and its columns there. More of
/// them beyond the limit than the percentile permits exclude a choice; they are far fewer than all
/// configurations.
class FailureSample {
 public:
  FailureSample(const ChoiceFigure&, std::size_t configurations);

  void add(const std::vector<std::uint32_t>& configurations);
  std::size_t size() const { return members_.size(); }

  /// Removes the options with which more configurations than permitted are beyond the limit even if all other
  /// joints have the least of their permitted weights.
  /// @returns whether a choice is left
  bool restrict(double limit, const std::vector<std::size_t>& offsets, PermittedOptions&, double& work) const;

 private:
  struct Values;
  bool fails(const Values&, double limit) const;
  void restrict_joint(std::size_t joint, const Values& least, const SumWeights&, double limit,
                      const std::vector<std::size_t>& offsets, PermittedOptions&, double& work) const;

  const ChoiceFigure* figure_;
  std::size_t permitted_;
  std::vector<std::uint32_t> members_;                     // ascending
  std::vector<std::vector<std::vector<double>>> columns_;  // [sum][column][member]
};

/// Cuts, the Lagrangian bound of the price that follows from them, and the removal of options by both.
class CutPool {
 public:
  explicit CutPool(const ChoiceProblem&);

  /// @param guide  not valid for all choices: only `usage` regards it
  void add(ChoiceCut, bool guide = false);
  std::size_t size() const { return cuts_.size(); }

  /// The limits of the figures, and the options that are looked at, from now on.
  void begin(const std::vector<double>& limits, const PermittedOptions&);

  /// Removes the options that no choice within the cuts and at most `most` in price has.
  /// @param bound  receives a lower bound of the price
  /// @returns whether a choice is left
  bool restrict(PermittedOptions&, std::int64_t most, std::int64_t& bound, double& work) const;

  /// Improves the multipliers of the Lagrangian min price + sum_r multiplier_r (cut_r - limit_r) over single
  /// options, whose maximum is a lower bound of the price.
  /// @param target  a price that is known to be reached, or none
  void improve_multipliers(const PermittedOptions&, std::optional<std::int64_t> target, double& work);

  /// Largest part of a limit that a choice uses, over all cuts and guides; above 1 it is beyond one.
  double usage(const OptionChoice&) const;

 private:
  struct Row {
    ChoiceCut cut;
    bool guide;
    double room, scale;  // the limit less the constant; parts are compared with room in units of scale
  };
  void set_room(Row&) const;
  double reduced(std::size_t option) const { return price_[option] + reduction_[option]; }
  std::int64_t rounded_up(double bound) const;
  bool remove_by_cuts(PermittedOptions&, bool& changed, double& work) const;
  bool remove_by_price(PermittedOptions&, std::int64_t most, std::int64_t& bound, bool& changed) const;

  std::vector<std::size_t> offsets_;
  std::vector<std::vector<std::size_t>> options_;  // [joint]: those that are looked at
  std::size_t count_ = 0;                          // of all of them
  std::vector<double> price_;                      // [option]
  std::int64_t base_ = 0, step_ = 1;               // every price of a choice is base + k step
  std::vector<double> limits_;
  std::vector<double> tolerances_;
  std::vector<Row> cuts_;
  std::vector<double> multipliers_;  // [cut]
  std::vector<double> reduction_;    // [option]: sum of multiplier * part / scale
  double reduction_of_rooms_ = 0;
};

}  // namespace qerr
