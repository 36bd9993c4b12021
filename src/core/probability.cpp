#include "core/probability.hpp"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/non_central_chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numbers>

namespace qerr {

double normal_cdf(double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); }

double normal_probability(double a, double b) {
  // Both values come from the tail on the side of the interval, so that their difference keeps its digits.
  const double sign = a + b < 0 ? -1 : 1;
  return 0.5 *
         std::abs(std::erfc(sign * a / std::numbers::sqrt2) - std::erfc(sign * b / std::numbers::sqrt2));
}

double normal_quantile(double probability) { return quantile(boost::math::normal(), probability); }

double student_t_tail(double t, double degrees) {
  return cdf(complement(boost::math::students_t(degrees), t));
}

double student_t_quantile(double probability, double degrees) {
  return quantile(boost::math::students_t(degrees), probability);
}

double chi_squared_tail(double x, double degrees) {
  return cdf(complement(boost::math::chi_squared(degrees), x));
}

double chi_squared_tail_quantile(double probability, double degrees) {
  return quantile(complement(boost::math::chi_squared(degrees), probability));
}

double noncentrality_for_power(double threshold, double degrees, double power) {
  return boost::math::non_central_chi_squared::find_non_centrality(degrees, threshold, 1 - power);
}

double fisher_f_tail(double f, double numerator_degrees, double denominator_degrees) {
  return cdf(complement(boost::math::fisher_f(numerator_degrees, denominator_degrees), f));
}

}  // namespace qerr
