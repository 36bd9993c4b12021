#pragma once

#include <Eigen/Core>
#include <vector>

namespace qerr {

/// |sum_k score_k e^{i n spacing argument_k}|^2 for n = first .. last.
///
/// The scores are spread over an even grid of arguments by a cubic B-spline, the grid is transformed, and the
/// transform of the spline is divided out. Source: Dutt and Rokhlin, "Fast Fourier transforms for
/// nonequispaced data", SIAM Journal on Scientific Computing 14 (1993), with a spline for their Gaussian. The
/// error is below 3 % of the largest power.
/// @param argument  from 0 to pi/spacing at most
std::vector<float> periodogram(const Eigen::ArrayXd& score, const Eigen::ArrayXd& argument, double spacing,
                               Eigen::Index first, Eigen::Index last);

/// The power at one rate, by its sum.
double power_at(const Eigen::ArrayXd& score, const Eigen::ArrayXd& argument, double rate);

/// Moves of a local search before it halves its step: it begins beside the maximum of a grid, a few steps
/// away. What still rises after that many is a slope without a maximum, on which it would go on for long.
inline constexpr int most_moves_of_step = 64;

/// Rates (orders, or angular frequencies) at which scores are most periodic in an argument.
struct RateScan {
  double least = 0, most = 0;  ///< rates to be scanned
  Eigen::Index most_peaks = 1;
};

/// Largest maxima of the periodogram |sum of scores e^{i rate argument}|^2, in descending order: on a grid
/// with half of the spacing 2 pi/range of independent rates, where a maximum between two has 0.81 of its
/// power, then refined by halving steps. Maxima within the spacing of independent rates of a larger one are
/// part of it.
/// @param hypotheses  receives the number of independent rates that were compared
std::vector<double> strongest_rates(const Eigen::ArrayXd& scores, const Eigen::ArrayXd& arguments,
                                    const RateScan&, double& hypotheses);

/// An event in time: the time of the best step, and the ramp and the exponential approach that fit best [s].
struct Event {
  double time = 0, ramp_start = 0, ramp_duration = 0, approach_start = 0, time_constant = 0;
  double hypotheses = 0;  ///< number of times that were compared; 0: none, the record is too short
};

/// The strongest change of weighted residuals that begins at one time and persists: the time of its step.
/// @param time  ascending
Event strongest_event(const Eigen::ArrayXd& residual, const Eigen::ArrayXd& weight,
                      const Eigen::ArrayXd& time);

/// Sets the ramp and the approach of an event.
void find_transitions(Event&, const Eigen::ArrayXd& residual, const Eigen::ArrayXd& weight,
                      const Eigen::ArrayXd& time);

/// A window of positions in which weighted residuals deviate.
struct Bump {
  double position = 0, width = 0;  ///< [units of the position]; width 0: none
  double hypotheses = 1;
};

Bump strongest_bump(const Eigen::ArrayXd& residual, const Eigen::ArrayXd& weight,
                    const Eigen::ArrayXd& position);

}  // namespace qerr
