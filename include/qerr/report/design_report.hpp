#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "qerr/bound/workspace.hpp"
#include "qerr/design/requirement.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// The encoder chosen for a joint.
struct DesignedEncoder {
  std::string joint;
  std::string name;             ///< of the option
  std::optional<double> price;  ///< empty: its catalogue states none
  double bits = 0;              ///< of a turn of the joint, or of 1 m: log2(2 pi/Delta) or log2(1 m/Delta)
};

/// The low-pass chosen for a filter of the spec.
struct DesignedFilter {
  std::string name, family;
  int order = 0;
  double cutoff = 0;  ///< [Hz]
  NamedFilter filter;
  double delay = 0;                ///< at 0 Hz [s]
  std::optional<double> tracking;  ///< largest tracking error up to `band`
  double band = 0;                 ///< [Hz]
  /// The quietest filter of `taps` taps with this tracking error over the band: ||H||_2 of the one found, and
  /// a bound that none falls below [1/s^derivative].
  struct BestLinear {
    std::size_t taps = 0;
    double h2 = 0, h2_bound = 0;
  };
  std::optional<BestLinear> best_linear;
};

/// A gain chosen for a joint's controller.
struct DesignedGain {
  std::string joint, key;  ///< kp or kd
  double value = 0;        ///< [N m/rad, N m s/rad, or N/m, N s/m]
};

/// A choice of encoders, filters and gains, with the requirements as `check` evaluates them.
struct Design {
  std::optional<double> price;  ///< empty: that of an encoder is not stated
  double bits = 0;              ///< sum over the joints
  std::vector<DesignedEncoder> encoders;
  std::vector<DesignedFilter> filters;
  std::vector<DesignedGain> gains = {};
  std::vector<RequirementResult> results;   ///< one for each requirement
  std::optional<double> minimized;          ///< value of the figure that is minimized
  std::vector<std::string> changes_by_set;  ///< KEY=VALUE, which make it of the spec
};

/// The least price, or sum of bits, with one requirement relaxed.
struct RequirementPrice {
  std::size_t requirement = 0;
  double relaxed = 0;           ///< fraction of the limit
  std::optional<double> price;  ///< empty: still none is found
  std::optional<double> bits;
  bool proven = true;
};

/// A design that no cheaper one equals in a figure; where costs are bits, none of fewer bits.
struct ParetoPoint {
  std::optional<double> price;
  double bits = 0, value = 0;
  std::vector<DesignedEncoder> encoders;
  bool proven = true;
};

/// The result of `qerr design`.
struct DesignReport {
  Spec spec;
  std::string goal;        ///< `price`, `resolution`, or a quantity with its statistic
  std::string goal_unit;   ///< of a quantity
  std::string price_unit;  ///< "" if no catalogue states one
  bool by_bits = false;    ///< costs are bits: the coarsest is looked for, or not all prices are stated
  std::optional<double> budget;
  std::optional<Design> optimal, runner_up;
  bool proven = true;
  std::optional<double> bound;  ///< of the price (bits, quantity), if it is not proven
  std::vector<RequirementPrice> requirement_prices;
  std::string pareto_figure, pareto_unit;
  std::vector<ParetoPoint> pareto;
  std::vector<ParetoPoint> uniform;  ///< one option at all chosen joints, whether it meets the limits or not
  /// Nothing feasible: the design whose largest value over its limit is least.
  std::optional<Design> finest;
  std::vector<std::string> obstacles;          ///< nothing feasible: why, in sentences
  std::vector<std::string> left_out;           ///< options that cannot count fast enough, in sentences
  std::vector<std::size_t> without_influence;  ///< requirements that no option changes
  std::string written;                         ///< the spec with the choice; "" if none is asked for or found
  std::vector<std::string> warnings;
};

/// Called within a search, with its number, from 1, and the part that is done of the work after which it ends
/// at the latest.
using SearchProgress = std::function<void(std::size_t search, double part)>;

struct DesignOptions {
  WorkspaceOptions workspace;
  SearchProgress search_progress;
  std::string pareto;        ///< quantity of the front; "": that of the tightest requirement
  bool alternatives = true;  ///< compute the prices of requirements and the front
  std::string target;        ///< path of the spec with the choice, to which its paths are relative; "": none
};

class SpecVariants;

/// The best choice that the section `design` of a spec permits.
/// @throws Error (input) if the spec has no such section, or states options that are not valid
DesignReport design(const SpecVariants&, const DesignOptions&);

}  // namespace qerr
