#pragma once

#include "diagnose/inference/tip/tip_model.hpp"

namespace qerr {

// What a term is worth in a model of the tip, and what it must be worth to be named.

inline constexpr double better_by = 3;      ///< of log-likelihood, beyond Bayes' criterion, for one more term
inline constexpr double without_name = 10;  ///< what has no name must be clearly better than what has one

/// Gain in log-likelihood by columns that stand across all that the model has, at its present weights.
double gain_of(const TipSolution&, const Eigen::MatrixXd& beyond);

/// How many rows say together what one would, were they independent: as blocks of the record say, and as the
/// encoders' quantization along the path says.
double inflation(const TipModel&, const TipSolution& with, const Eigen::MatrixXd& columns);

/// The same of a term that the model has.
double inflation(const TipModel&, std::size_t term);

/// Of a gain in log-likelihood by that many coefficients, once correlation is taken off.
double p_value(double gain, Eigen::Index coefficients);

/// Rms of what columns add, over the rms of all noise.
double loudness(const TipSolution&, const Eigen::MatrixXd& columns, const Eigen::VectorXd& coefficients);

/// How many times as loud as a dimension a term must be. Quantization at slow speeds is not white, and looks
/// a little like anything that follows the motion: a dimension it resembles least, the best of many orders
/// most.
double times_as_loud(const TipTerm&);

/// What a term must gain beyond a named dimension's.
double penalty(const TipModel&, const TipTerm&);

/// What coefficients cost by Bayes' criterion (Schwarz).
double price(const TipModel&, Eigen::Index coefficients);

}  // namespace qerr
