#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/filter/filter.hpp"
#include "qerr/simulate/simulate.hpp"
#include "simulate/sensing.hpp"

namespace qerr {

/// Initial part of a motion that statistics exclude [s]: `motion.settling`, or where it is not given, until
/// the transients of all filters have decayed to 1e-3, at most half of the motion.
double settling_time(const Motion&, const std::vector<Filter>&);

/// Longest record along which the figures of a motion are computed [samples]: some seconds.
inline constexpr std::uint64_t longest_record = 20'000'000;

/// The samples of a motion that a filter of a given rate uses, read by encoders with effects but without the
/// rounding to counts.
///
/// As in a simulation, a filter whose rate divides that of the motion uses every n-th sample, and samples
/// before the settling do not count; for any other rate the motion is sampled at that rate.
class UnroundedRecord {
 public:
  /// @param settling  initial part that does not count [s]
  UnroundedRecord(const Motion&, double rate, double settling);

  std::uint64_t samples() const { return samples_; }                            ///< that are read
  std::uint64_t filter_samples() const { return (samples_ - 1) / every_ + 1; }  ///< that the filter uses
  /// Samples that the filter uses after the settling.
  std::uint64_t samples_after_settling() const { return filter_samples() - (settled_ + every_ - 1) / every_; }
  bool is_after_settling(std::uint64_t sample) const { return sample >= settled_; }

  /// Calls visit(batch, the used samples in it) for all batches in the order of time.
  template <class Visit>
  void read(const OperationalModel& model, const std::vector<Effect>& effects, Visit visit) const {
    const auto n = std::ssize(model.transmission.encoders);
    read(model, effects, Eigen::VectorXd::Zero(n), visit);
  }

  /// @param displacement  of the encoders' coordinates [rad or m]
  template <class Visit>
  void read(const OperationalModel& model, const std::vector<Effect>& effects,
            const Eigen::VectorXd& displacement, Visit visit) const {
    Sensing sensing(model, motion_, effects, {.displacement = displacement, .rounds = false});
    std::vector<std::size_t> used;
    for (std::uint64_t first = 0; first < samples_; first += batch_size) {
      const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(batch_size, samples_ - first));
      const SensedBatch& batch = sensing.sense(first, count);
      used.clear();
      for (std::size_t i = 0; i < count; ++i)
        if ((first + i) % every_ == 0) used.push_back(i);
      if (!used.empty()) visit(batch, used);
    }
  }

 private:
  Motion motion_;
  std::uint64_t every_ = 1, samples_, settled_;
};

}  // namespace qerr
