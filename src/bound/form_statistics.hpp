#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "bound/column_statistics.hpp"
#include "lanes/batch.hpp"

namespace qerr {

/// Power of two that brings a number that is not negative between 1/2 and 1; 1 for 0.
double power_to_unit(double);

/// Evaluates tiles of forms of one coordinate, and owns what that needs: one for each thread.
class FormStatistics {
 public:
  FormStatistics(const ColumnStatistics&, std::size_t coordinate, bool squared);

  /// @pre at most forms_per_tile forms
  void evaluate(std::span<const ColumnForm>);

 private:
  /// Which of a form's two figures: its values are those of the form plus a remainder.
  struct Figure {
    const ColumnForm* form;
    bool rigorous;
  };
  /// A range of a form's values in float.
  struct Range {
    double lower, upper;
  };

  void set_weights(std::span<const ColumnForm>);
  void set_bands(std::span<const ColumnForm>);
  std::vector<Range> bands_of(float* sample, double spread) const;
  void scan();

  void finish(std::size_t form, Figure, Statistic&);
  double mean(Figure) const;
  double rigorous_at(const ColumnForm&, double linear, std::size_t place) const;
  double value_at(Figure, std::size_t place) const;
  /// Spread of the remainder over the configurations, in the units of the floats.
  double spread(const ColumnForm&, double unit) const;
  /// Values in float that exact values can have which may be equal to one with the value x in float.
  Range ambiguous(double x, double spread) const;

  double order_statistic(std::size_t form, Figure, std::uint64_t rank);
  std::optional<double> screened(std::size_t form, Figure, std::uint64_t rank);
  double ranked(const ScreenBand&, std::uint64_t rank);
  double of_all(Figure, std::uint64_t rank);

  const ColumnStatistics& s_;
  std::size_t coordinate_;
  bool squared_;
  double error_;                            // relative, of a float sum
  std::vector<float> weights_;              // [form][column], scaled
  std::vector<double> units_;               // [form]: of the floats
  std::vector<double> spreads_;             // [form]
  std::vector<float> sample_;               // [form][place]
  std::vector<std::vector<Range>> ranges_;  // [form]
  std::size_t bands_per_form_ = 0;
  std::vector<ScreenBand> bands_;  // [form][band]
  const ScreenBand* ranked_of_ = nullptr;
  std::vector<std::pair<std::uint64_t, float>> ranked_;  // values of that band in float, by rank in it
  std::vector<std::int32_t> near_;                       // places that can have the wanted rank
  std::vector<double> exact_;                            // their values
  std::vector<double> all_;                              // values of all configurations of the figure below
  Figure all_of_{nullptr, false};
};

}  // namespace qerr
