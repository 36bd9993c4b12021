#pragma once

#include <optional>
#include <vector>

#include "control/control.hpp"
#include "filter/design/ratio.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {

/// Position of M q'' + b q' = u at the samples, u held between them and delayed: the pulse transfer function
/// with zero-order hold, by the step response s(t) = t^2/M (1/2! - x/3! + x^2/4! - ...), x = b t/M, in 1024
/// bits, so that no digits are lost at high rates.
/// @param late  part of a sample in [0, 1) by which the torque is late; whole samples, and the one of the
/// hold itself, are z^-1 each beside it
TransferRatio plant_of(double inertia, double damping, double sample_rate, double late);

/// F = kp + kd H_v: an error e of the position adds -F e to the torque.
Filter controller_of(const JointController&, double sample_rate);

/// A joint's loop, L = z^-delays * plant * controller, the factor of the reading in the controller.
struct Loop {
  double sample_rate = 0;
  TransferRatio plant, controller;
  std::size_t delays = 0;
  LoopReading reading = {};

  TransferRatio undelayed() const;  ///< plant * controller, with |L| on the unit circle
  TransferRatio open() const;       ///< L
};

Loop loop_of(const Control&, std::size_t joint, double inertia);

/// What an error e of the position reading does in the closed loop: the true motion is -L/(1 + L) e, the
/// torque -C/(1 + L) e; both divided by the factor of the reading, beside which the error stands.
struct ClosedLoop {
  Filter motion;  ///< L/(1 + L)
  Filter torque;  ///< C/(1 + L) [N m/rad or N/m]
};

/// Empty: unstable, or within 1e-12 of it.
std::optional<ClosedLoop> closed(const Loop&);

/// The loop's margins, from the roots of polynomials in Omega^2, w = j Omega: no grid.
struct LoopMargins {
  bool stable = false;
  /// Factors of the gain at which the loop is marginal, ascending: 1/|L| where L is negative.
  std::vector<double> critical_gains;
  /// The least factor above 1 at which a stable loop becomes unstable; infinite: none. Of an unstable loop
  /// the largest below which it is stable, and 0 if there is none.
  double gain = 0;
  double lower_gain = 0;        ///< the largest factor below 1 at which a stable loop is marginal; 0: none
  std::optional<double> phase;  ///< least |180 deg + arg L| where |L| = 1 [rad]; empty: |L| is never 1
  std::optional<double> crossover;           ///< where that is [Hz]
  std::optional<double> critical_frequency;  ///< where L is negative and 1/|L| is `gain` [Hz]
  std::optional<double> bandwidth;           ///< where |L/(1 + L)| is 1/sqrt(2) of its value at 0 Hz [Hz]
  /// Re L > -1/2 at all frequencies: no oscillation between counts exists, whatever the motion (Tsypkin; the
  /// sector of rounding is [0, 2], [0, 2/w] with a state of w counts). Never claimed beside play.
  bool absolutely_stable = false;
};

LoopMargins margins(const Loop&);

/// The describing function of rounding to multiples of a count, for a sine of amplitude A counts: centred on
/// a count, N = (4/(pi A)) sum sqrt(1 - ((2i - 1)/(2A))^2), at most 4/pi; or on the edge between two.
double describing_function(double amplitude, bool on_edge);

/// A motion that play is predicted to keep alive.
struct PlayCycle {
  double amplitude = 0;  ///< of the joint [rad or m]
  double frequency = 0;  ///< [Hz]
};

/// The largest sine at which L N = -1, N(A) the describing function of play of a width g: for an encoder on
/// the driving side, which leads by g/2 in the direction of motion, 1 + 2j g/(pi A); behind the play, with b
/// = 1 - g/A, (pi/2 + asin b + b sqrt(1 - b^2))/pi - j (1 - b^2)/pi for A above g/2. Empty: none is
/// predicted. Searched on a grid of 600 frequencies a loop, the crossings to double precision.
std::optional<PlayCycle> play_cycle(const Loop&, double play, bool behind_play);

/// What quantization and play may keep alive in a loop at rest.
struct LimitCycle {
  double bound = 0;                    ///< no lasting motion is larger [rad or m]
  double torque_bound = 0;             ///< likewise, of the torque [N m or N]
  bool on_count = false;               ///< the describing function predicts one about a count
  bool on_edge = false;                ///< or about the edge between two counts
  double edge_amplitude = 0;           ///< of the motion predicted there [rad or m]
  double frequency = 0;                ///< predicted [Hz]
  double torque_step = 0;              ///< largest torque that follows one count [N m or N]
  double ending_friction = 0;          ///< Coulomb friction that ends one between two counts [N m or N]
  std::optional<PlayCycle> play = {};  ///< of a loop whose reading has play
};

/// With T = L/(1 + L), the bounds are ||T||_1 (e + d), d the error that depends on the position: at most its
/// half width, and at most its slope s times the motion, so that ||T||_1 e/(1 - s ||T||_1) is a bound, too.
/// @param motion, torque  ||L/(1 + L)||_1 and ||C/(1 + L)||_1
/// @param step            of largest_step
/// @param count           of the joint [rad or m]: twice the half width of its rounding error
/// @param lasting         half width e of the error that lasts at rest [rad or m]
LimitCycle limit_cycle(const LoopMargins&, double motion, double torque, double step, const LoopReading&,
                       double count, double lasting);

/// The largest value of a controller's response to a unit step [N m/rad or N/m].
double largest_step(const Filter& controller);

}  // namespace qerr
