#pragma once

#include "diagnose/inference/tip/tip_model.hpp"

namespace qerr {

// Criteria by which terms are added to a model of the tip. The thresholds are conventions.

inline constexpr double better_by = 3;  ///< of log-likelihood, beyond Bayes' criterion, for one more term
inline constexpr double unnamed_penalty =
    10;  ///< log-likelihood by which an unnamed term must be better than a named one

/// Log-likelihood gain of columns that are orthogonal to the model's, at its present weights.
double gain_of(const TipSolution&, const Eigen::MatrixXd& beyond);

/// Variance inflation by correlated rows: the larger of the estimate from blocks of the record and of that
/// from the encoders' quantization along the path.
double variance_inflation(const TipModel&, const TipSolution& with, const Eigen::MatrixXd& columns);

/// Variance inflation of a term that the model has.
double variance_inflation(const TipModel&, std::size_t term);

/// Tail probability of chi squared with that many degrees of freedom at twice a log-likelihood gain, which is
/// corrected for correlation.
double p_value(double gain, Eigen::Index coefficients);

/// Rms of a term's addition over the rms of all noise.
double signal_to_noise(const TipSolution&, const Eigen::MatrixXd& columns,
                       const Eigen::VectorXd& coefficients);

/// Required signal-to-noise ratio, relative to a dimension's. Quantization at low speed is not white and
/// correlates with the motion: least with a dimension, most with the best of many orders.
double required_signal_to_noise(const TipTerm&);

/// Log-likelihood that a term must gain beyond a named dimension.
double penalty(const TipModel&, const TipTerm&);

/// Price of coefficients in Schwarz's Bayesian criterion.
double price(const TipModel&, Eigen::Index coefficients);

}  // namespace qerr
