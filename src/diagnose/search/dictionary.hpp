#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "diagnose/record/sampling.hpp"
#include "diagnose/search/peaks.hpp"
#include "effect/term.hpp"

namespace qerr {

/// A possible part of an encoder's error.
struct Candidate {
  std::shared_ptr<const Term> term;  ///< its columns over the samples
  std::string family;                ///< a model has at most one member of a family
  double alternatives = 1;           ///< size of the family, for the price of the choice
  double least = 0, most = 0;        ///< range of its coefficient in which the columns hold; 0, 0: any
  std::size_t scanned = 0;           ///< number of its event or place in the list of what scans have found
  /// The record covers so little of its period that a search chooses it only in the place of a curve without
  /// a name: it may be what a chosen term imitates.
  bool replaces_only = false;
  /// The term over another sampling of the record.
  std::function<Term(const Sampling&)> over;
};

/// What scans of the residual have found, and refined shapes of what was chosen.
struct Scanned {
  struct Rate {
    double value = 0, hypotheses = 1;
    bool whole = false;  ///< a whole order that was chosen: its free neighbours are not tried again
  };
  struct Linearization {
    std::string effect;
    Eigen::VectorXd parameters;
  };
  std::vector<Rate> orders, loaded_orders, lines;
  std::vector<Event> events;
  std::vector<Bump> places;
  std::vector<double> time_constants;         ///< refined ones [s]
  std::vector<Linearization> linearizations;  ///< parameters about which non-linear effects are linearized
  std::vector<double> hystereses;             ///< sizes found of a hysteresis [rad or m]
  std::vector<double> travels;  ///< of a friction: beside the one found, and that one [rad or m]
};

/// A term that has been found, and what it adds at the samples [rad or m].
struct Addition {
  Term term;
  Eigen::ArrayXd added;
};

/// Every candidate for a record: all terms of the catalogue's effects, those that scans suggest, and shapes
/// that the catalogue does not have.
class Dictionary {
 public:
  /// Borrows the sampling, which must outlive it.
  explicit Dictionary(const Sampling& s) : sampling_(&s) {}

  /// @param displacing  what displaces the position on which others depend
  std::vector<Candidate> candidates(const Scanned&, const std::vector<Addition>& displacing);

 private:
  const Sampling* sampling_;
  /// Columns that depend on the history of the whole record or on the samples alone, by family and shape:
  /// they are the same in every pass.
  std::map<std::pair<std::string, double>, std::shared_ptr<const Term>> histories_;
  std::map<double, bool> driven_;  ///< whether the readings drive a hysteresis of this size
  /// Parameters that the whole record tells, by effect: the same in every pass, too.
  std::map<std::string, std::vector<double>> shapes_;
};

/// Clocks of the encoder at the parameters that a search has found.
std::vector<Effect> clocks_of(const RecordSignals&, const Scanned&);

/// Family of a named order, by its wave number in the joint.
std::string family_of_order(double wave_number);

/// A term whose constant part is one more column: a linearization is searched as if its parts were free.
Term searchable(Term);

/// The named whole orders within the resolution of a free order.
std::vector<Term> whole_orders_near(const RecordSignals&, double order);

}  // namespace qerr
