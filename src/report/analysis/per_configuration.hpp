#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "qerr/input/spec.hpp"

/// The columns of `qerr analyze --per-configuration`, as CSV and as numbers.
namespace qerr {

struct ConfigurationBatch;

/// The headers of the columns.
/// @param noise  of `noise_in_motion`
std::vector<std::string> per_configuration_names(const Spec&, const std::vector<Eigen::VectorXd>& noise);

/// The values of the configurations of a batch, a row each; NaN where sigma is not known.
/// @param spec  its model as the errors were computed with, error sources of the effects included
std::vector<double> per_configuration_numbers(const Spec& spec, const std::vector<Eigen::VectorXd>& noise,
                                              const ConfigurationBatch&);

/// @param noise  of `noise_in_motion`
std::string per_configuration_header(const Spec&, const std::vector<Eigen::VectorXd>& noise);

/// One row for each configuration of the batch.
/// @param spec  its model as the errors were computed with, error sources of the effects included
std::string per_configuration_rows(const Spec& spec, const std::vector<Eigen::VectorXd>& noise,
                                   const ConfigurationBatch&);

}  // namespace qerr
