#pragma once

#include <string>

#include "race.hpp"

namespace qerr::bench {

/// Machine and compiler of the measurement.
struct Setting {
  std::string machine;   ///< the processor's name
  std::string compiler;  ///< of the benchmark
  RaceOptions options;
  std::uint64_t configurations = 0, compared = 0;
};
Setting setting(const RaceOptions&, std::uint64_t configurations, std::uint64_t compared);

/// Tables as text: aligned columns, or Markdown.
std::string text(const Results&, const Setting&, bool markdown);

/// Deviations of every contestant from the reference, as a table.
std::string agreement(const Results&, bool markdown);

/// All figures, rates in 1/s.
std::string json(const Results&, const Setting&);

}  // namespace qerr::bench
