#pragma once

#include <atomic>
#include <map>
#include <string>
#include <vector>

#include "qerr/input/read_log.hpp"
#include "qerr/report/analysis.hpp"

namespace qerr::cli {

/// A program that runs commands within its own process, such as Python: reports and warnings go to it in
/// place of standard output and standard error.
struct Caller {
  std::vector<std::string> formats;            ///< in which it wants the report
  std::vector<LogArray> log;                   ///< in place of the files of a log
  std::map<std::string, std::string> reports;  ///< by format
  std::vector<std::string> warnings;
  bool wants_columns = false;  ///< of `analyze`: the figures of every configuration
  ConfigurationColumns columns;
  std::atomic<bool> stops = false;  ///< set by the caller: the work that shows progress ends with Stopped
};

/// Work that the caller has stopped.
struct Stopped {};

/// The caller of the running command; null: the program `qerr` itself.
inline Caller*& caller() {
  static Caller* current = nullptr;
  return current;
}

}  // namespace qerr::cli
