#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/design/requirement.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/report/analysis.hpp"
#include "qerr/report/write.hpp"
#include "report/page/page.hpp"

/// Parts of the table of `analyze`.
namespace qerr {

/// Unit of what a filter passes over what enters: `1/s` of a velocity, "" of a position.
std::string rate_unit(int derivative);

/// The unit of a signal, m or rad, behind a filter; "" behind a control law that states none.
std::string shown_unit(std::string_view unit, const Filter&);

/// 0 for rounding errors of sines and cosines: no length, angle or derivative of one is this small.
double cleaned(double value);

/// Ellipsoids of one sigma of the tip's position or rotation, in the axes of the analysis.
struct TipEllipsoids {
  std::string_view of, unit;  ///< `position` in m, `rotation` in rad
  ErrorEllipsoid mean;        ///< of the covariance's mean over the configurations
  ErrorEllipsoid at_largest;  ///< where the trace of the position's covariance is largest
};

/// The ellipsoids of x y z and of rx ry rz, if all three are among the coordinates.
std::vector<TipEllipsoids> tip_ellipsoids(const Analysis&);

/// Proven maxima in the report of `analyze`.

/// Adds the proofs that are asked for or required, and a warning of gaps that are wider than the one asked
/// for.
/// @throws Error (input; key `requirements`) for a required figure that is not known
void add_proofs(Analysis&, const ProofRequest&, unsigned threads);

/// The section of the table: sampled, reached and proven maximum of each figure; "" without proofs.
std::string proof_table(const Analysis&, const Style&);

}  // namespace qerr

namespace qerr::page {

/// What a page is about: its spec with hash and overrides, the encoders, and the verdict of each requirement.
/// @param results  of the spec's requirements; empty: the page does not judge them
/// @param caption  whose results they are, if not those of the spec itself
std::string title_block(const Spec&, const std::optional<std::vector<RequirementResult>>& results,
                        const std::string& caption = "");

/// The title block at the head of a page, and the spec's text at its end.
void describe(Page&, const Spec&, const std::optional<std::vector<RequirementResult>>& results,
              const std::string& caption = "");

/// Each requirement with its verdict, value, margin, the part of its limit that is used, the configuration
/// where its quantity is largest and, with overrides, its value without them.
std::string requirement_table(const Spec&, const std::vector<RequirementResult>& results,
                              const std::string& caption = "");

}  // namespace qerr::page

namespace qerr {

/// Figures at single configurations of an analysis, for pictures: of all, or of so many that a picture does
/// not show the difference.
struct ConfigurationSample {
  std::uint64_t of = 0;                    ///< configurations of the analysis
  std::vector<Eigen::VectorXd> q;          ///< [rad or m]
  std::vector<Eigen::Vector3d> tips;       ///< in the base frame [m]
  std::vector<std::vector<double>> worst;  ///< [coordinate or length][configuration]: worst case
  std::vector<double> trace;               ///< [configuration]: variance of the position
  /// [figure]: values of `for_each_figure` in its order; sorted.
  std::vector<std::vector<double>> distributions;

  bool complete() const { return q.size() == of; }
};

/// The robot where the trace of the position's covariance is largest, and where it is the median of the
/// sample, with the ellipsoid of one sigma and the box of the worst case at the tip, in three views each.
std::string robot_figures(const Analysis&, const ConfigurationSample&);

/// Largest speed of the coordinate of each encoder, C^-1 q', along the spec's motion, else at the URDF's
/// velocity limits of all joints at once [rad/s or m/s]; empty: not known.
using EncoderSpeeds = std::vector<std::optional<double>>;
EncoderSpeeds encoder_speeds(const Spec&);

/// What an encoder's counter can follow.
struct CountLimit {
  double rate = 0;   ///< [counts/s]
  std::string what;  ///< that limits it, in words
};

/// The lower one of the stated rate and of half a turn of the counter, 2^(bits - 1) counts, in each sample of
/// the slowest filter; empty: none is stated, or no filter takes differences.
std::optional<CountLimit> count_limit(const Spec&, std::size_t encoder);

/// |gear ratio| counts_per_rev speed/(2 pi) [counts/s].
double count_rate(const Spec&, std::size_t encoder, double speed);

/// The largest speed at which the encoder's counter can follow [rad/s or m/s]; empty: no limit is stated.
std::optional<double> largest_speed(const Spec&, std::size_t encoder);

/// A row for each encoder whose count rate is limited: its speed, its rate, their limits; "" if none is.
std::string count_rate_table(const Spec&, const Style&);

/// `120000 counts/s at 3.00 rad/s (the URDF's limit), at most 100000: its max_count_rate`.
/// @pre there is a limit
std::string count_rate_text(const Spec&, std::size_t encoder, double speed);

/// Encoders that cannot count as fast as they turn, and those of which it is not known.
std::vector<std::string> count_rate_warnings(const Spec&);

/// The value of a requirement on a count rate.
/// @throws Error (input) if the speed is not known
double required_count_rate(const Requirement&, const Spec&, const EncoderSpeeds&);

}  // namespace qerr
