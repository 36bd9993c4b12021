#pragma once

#include <map>
#include <tuple>

#include "bound/error_columns.hpp"
#include "design/choice_figure.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// The weights of the columns for every option of every joint, the other joints being as in the spec.
struct OptionWeights {
  ErrorWeights stated;                             ///< of the spec itself
  std::vector<std::vector<ErrorWeights>> options;  ///< [joint][option]
  std::vector<std::size_t> owners;                 ///< [column]: the joint whose options change it, else any
  bool biased = false;                             ///< an option's errors have a mean
  bool along_motion = false;                       ///< options change what effects add along the motion
};

/// Finds `owners`, `biased` and `along_motion`.
/// @throws Error (input) if the options of two joints change one column: their errors would not add
void find_owners(OptionWeights&, const Spec&);

/// The figures of requirements as weighted sums over columns of errors.
class FigureSums {
 public:
  /// @param spec, columns  must outlive it
  FigureSums(const Spec& spec, const ErrorColumns& columns) : spec_(spec), columns_(columns) {}
  FigureSums(const FigureSums&) = delete;
  FigureSums& operator=(const FigureSums&) = delete;

  /// The figure borrows coefficients of this object.
  ///
  /// The worst case of a length is bounded from below by its component in one direction at each
  /// configuration: that of the largest length for the reference, and by the components along the axes.
  /// @param reference  a choice
  ChoiceFigure figure(const Requirement&, const OptionWeights&, const OptionChoice& reference);

 private:
  enum class Part { magnitude, square, positive, negative };

  WeightedSum sigma_sum(const Requirement&, const OptionWeights&);
  std::vector<WeightedSum> worst_sums(const Requirement&, const OptionWeights&, std::size_t coordinate);
  std::vector<WeightedSum> length_sums(const Requirement&, const OptionWeights&,
                                       const OptionChoice& reference);
  bool is_of_length(const Requirement&) const;
  std::size_t row_of(const Requirement&) const;
  std::size_t component(const Requirement&, std::size_t axis) const;
  const double* part(std::size_t coordinate, std::size_t column, Part);
  const double* squares_of_length(const Requirement&, std::size_t column);

  const Spec& spec_;
  const ErrorColumns& columns_;
  std::map<std::tuple<std::size_t, std::size_t, Part>, AlignedNumbers> parts_;
  std::map<std::pair<std::size_t, std::size_t>, AlignedNumbers> squares_of_lengths_;
  std::vector<AlignedNumbers> along_;  // components of lengths
};

}  // namespace qerr
