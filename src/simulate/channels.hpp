#pragma once

#include <algorithm>

#include "qerr/bound/operational_error.hpp"

namespace qerr {

/// Layout of the filtered signals of every coordinate: the exact error, its linear part J e, the contribution
/// of every encoder to that, and, if errors have a mean, the mean error along the path.
struct Channels {
  Eigen::Index coordinates, encoders;
  bool biased;

  explicit Channels(const OperationalModel& model)
      : coordinates(static_cast<Eigen::Index>(model.coordinates.size())),
        encoders(static_cast<Eigen::Index>(model.transmission.encoders.size())),
        biased((mean_errors(model.transmission).array() != 0).any() ||
               std::any_of(model.sources.begin(), model.sources.end(),
                           [](const IndependentError& source) { return source.mean != 0; })) {}

  Eigen::Index count() const { return coordinates * (2 + encoders + (biased ? 1 : 0)); }
  Eigen::Index linear() const { return coordinates; }
  Eigen::Index part(Eigen::Index encoder) const { return coordinates * (2 + encoder); }
  Eigen::Index mean() const { return coordinates * (2 + encoders); }
};

}  // namespace qerr
