#pragma once

/// Distribution functions, compiled once (Boost.Math with its default policy: relative error about 1e-14).
/// A tail is P(X > x); a quantile is the value x with P(X <= x) = p. Degrees of freedom are > 0 and need not
/// be integers.
/// @throws std::domain_error outside the domain of the distribution
namespace qerr {

/// P(X <= z) of the standard normal distribution.
double normal_cdf(double z);

/// P(a < X <= b) of the standard normal distribution, a <= b, without cancellation in either tail.
double normal_probability(double a, double b);

double normal_quantile(double probability);

double student_t_tail(double t, double degrees);
double student_t_quantile(double probability, double degrees);

double chi_squared_tail(double x, double degrees);

/// The x at which the tail is `probability`.
double chi_squared_tail_quantile(double probability, double degrees);

/// Noncentrality at which P(X > threshold) = power for a noncentral chi-squared X.
double noncentrality_for_power(double threshold, double degrees, double power);

/// Tail of the F distribution.
double fisher_f_tail(double f, double numerator_degrees, double denominator_degrees);

}  // namespace qerr
