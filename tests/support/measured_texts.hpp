#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <string>

#include "qerr/core/error.hpp"

namespace qerr::testing {

/// The counterpart of `Measured` for texts: lines `NAME: TEXT` in a file of tests/golden with a first line of
/// explanation. A deliberate change replaces them by the lines that a failure prints.
class MeasuredTexts {
 public:
  explicit MeasuredTexts(const std::string& file) {
    std::ifstream stream(QERR_SOURCE_DIR "/tests/golden/" + file);
    std::string line;
    std::getline(stream, line);
    while (std::getline(stream, line)) {
      const std::size_t colon = line.find(": ");
      texts_[line.substr(0, colon)] = line.substr(colon + 2);
    }
  }

  /// @param name  without ": "
  void expect(const std::string& name, const std::string& text) const {
    const auto at = texts_.find(name);
    ASSERT_NE(at, texts_.end()) << "not measured: " << name << ": " << text;
    EXPECT_EQ(text, at->second) << name << ": " << text;
  }

 private:
  std::map<std::string, std::string> texts_;
};

/// The parts of all faults that the action throws, or `taken` if it throws none.
template <typename Action>
std::string answer_to(Action action) {
  try {
    action();
  } catch (const Error& error) {
    std::string text;
    for (const Fault& f : error.faults())
      text +=
          (text.empty() ? "" : " || ") + f.key + " | " + f.rule + " | " + escaped(f.found) + " | " + f.remedy;
    return text;
  }
  return "taken";
}

}  // namespace qerr::testing
