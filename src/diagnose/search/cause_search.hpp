#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "diagnose/record/sampling.hpp"
#include "diagnose/search/dictionary.hpp"
#include "diagnose/search/error_model.hpp"

namespace qerr {

/// A part of an encoder's error that the search has chosen.
struct ChosenTerm {
  Candidate candidate;
  Eigen::VectorXd coefficients;
  double p_value = 1;  ///< F test of the model without it, in independent samples
  double lost = 0;     ///< mean square that the model without it does not explain [rad^2 or m^2]
  double rms = 0;      ///< of its addition about its mean [rad or m]
};

/// A term that explains as much in the place of a chosen one.
struct Replacement {
  std::size_t instead_of = 0;  ///< number of the chosen term
  Candidate candidate;
};

/// Smallest size of an effect that a record would have shown.
struct VisibleEffect {
  std::string effect, parameter;
  double smallest = 0;    ///< of the parameter [SI]; 0: the record cannot show it
  std::string hidden_by;  ///< why it cannot: "standstill", "one way", ...; else ""
};

struct FoundCauses {
  std::vector<ChosenTerm> chosen;  ///< in descending order of the variance that each removes alone
  std::vector<Replacement> replacements;
  std::vector<VisibleEffect> visible;
  double samples_per_reading = 1;  ///< integrated autocorrelation of the residual of the richest model
  double explained = 0;            ///< mean square that all terms remove [rad^2 or m^2]
};

/// Finds the set of terms that explains an encoder's error.
///
/// A linear regression of error samples on all candidates of the dictionary, in which the set of terms is
/// searched as a whole (linear_model.hpp), alternates with scans of the residual for orders, lines, steps and
/// bumps and with the refinement of time constants and sizes; the search begins anew each time.
/// @param with_names  whether effects of the catalogue may be causes
FoundCauses search_causes(const Evidence& record, std::uint64_t seed, bool with_names = true);

/// Counts are lost in whole numbers: other chosen steps become uncatalogued ones.
void distinguish_steps(const ErrorModel&, Choice&);

/// What a choice says: its terms in descending order of the variance that each removes alone, their
/// alternatives, and what the record would have shown.
FoundCauses found_causes(const ErrorModel&, const Choice&);

/// For each effect that was not found, the size at which one of its terms would have passed the criterion
/// beside what was found, or what hides it.
std::vector<VisibleEffect> visible_effects(const ErrorModel&, const Choice&);

}  // namespace qerr
