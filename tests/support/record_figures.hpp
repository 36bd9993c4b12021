#pragma once

#include <cmath>
#include <string>
#include <utility>

#include "support/measured.hpp"

namespace qerr::testing {

/// The measured figures of one record: rows `RECORD,FIGURE,VALUE`, of which none may be missing in the end.
class RecordFigures {
 public:
  /// @param measured  must outlive this
  RecordFigures(const Measured& measured, std::string record)
      : measured_(measured), record_(std::move(record)) {}
  ~RecordFigures() { measured_.expect_all_met(record_ + ','); }
  RecordFigures(const RecordFigures&) = delete;
  RecordFigures& operator=(const RecordFigures&) = delete;

  void operator()(const std::string& figure, double value) const {
    // Below are the rounding errors of zeros.
    measured_.expect(record_ + ',' + figure, std::abs(value) < 1e-16 ? 0 : value);
  }

 private:
  const Measured& measured_;
  std::string record_;
};

}  // namespace qerr::testing
