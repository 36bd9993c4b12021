#pragma once

#include <span>
#include <vector>

#include "bound/column_statistics.hpp"
#include "qerr/bound/workspace.hpp"

namespace qerr {

/// A model whose workspace is wanted.
struct ColumnModel {
  const OperationalModel* model;
  const std::vector<Norms>* filters;
  ErrorWeights weights;
};

/// Whether ErrorColumns give a model's figures over these configurations as `workspace` does: percentiles are
/// exact, no error has a mean, and there are no lengths, no signals of other kinds and no Euler angles.
bool have_columns(const OperationalModel&, const Configurations&);

/// The statistics of `workspace` for models that share their columns, as far as reports of a sweep have them:
/// coordinates without shares, derivatives and the encoders' parts of the mean variance. They equal those of
/// `workspace` but for rounding, 1e-12 relative.
/// @pre have_columns(model, configurations) for all of them
std::vector<Workspace> workspaces(const ColumnStatistics&, std::span<const ColumnModel>);

}  // namespace qerr
