#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace qerr {

/// A place in an input document. Line and column count from 1; 0 means unknown.
struct Place {
  std::string file;
  int line = 0;
  int column = 0;
};

/// One fault of the input: its place, the broken rule, the value found and the remedy.
///
/// Printed as `FILE:LINE:COLUMN: KEY: RULE, found FOUND; REMEDY`; empty parts are omitted.
struct Fault {
  Place place;
  std::string key;     ///< dotted path, e.g. `encoders.elbow.bits`, or `joint 'elbow'` in a URDF
  std::string rule;    ///< the rule that was broken
  std::string found;   ///< the value found, in quotation marks if it is text of the user
  std::string remedy;  ///< how to correct it
};

/// The kind of an error; its value is the exit code of the program.
enum class Trouble { usage = 2, input = 3, file_system = 4, internal = 5 };

/// The exception type of qerr, with all faults of one input.
class Error : public std::runtime_error {
 public:
  explicit Error(Fault fault, Trouble trouble = Trouble::input);
  /// An error of one fault, with or without its place.
  Error(Place place, std::string key, std::string rule, std::string found, std::string remedy,
        Trouble trouble = Trouble::input);
  Error(std::string key, std::string rule, std::string found, std::string remedy,
        Trouble trouble = Trouble::input);
  explicit Error(std::vector<Fault> faults, Trouble trouble = Trouble::input);
  const std::vector<Fault>& faults() const { return faults_; }
  Trouble trouble() const { return trouble_; }

 private:
  std::vector<Fault> faults_;
  Trouble trouble_;
};

/// One line per fault, control characters escaped, at most 20 lines in all.
std::string format(const std::vector<Fault>& faults);

/// The text with control characters, DEL and invalid UTF-8 written as \xNN, cut to `limit` bytes, so that it
/// is safe to print to a terminal.
std::string escaped(const std::string& text, std::size_t limit = 200);

}  // namespace qerr
