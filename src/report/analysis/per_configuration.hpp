#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "qerr/input/spec.hpp"

/// The CSV of `qerr analyze --per-configuration`.
namespace qerr {

struct ConfigurationBatch;

/// @param noise  of `noise_in_motion`
std::string per_configuration_header(const Spec&, const std::vector<Eigen::VectorXd>& noise);

/// One row for each configuration of the batch.
/// @param spec  its model as the errors were computed with, error sources of the effects included
std::string per_configuration_rows(const Spec& spec, const std::vector<Eigen::VectorXd>& noise,
                                   const ConfigurationBatch&);

}  // namespace qerr
