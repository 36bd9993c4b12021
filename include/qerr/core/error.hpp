#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace qerr {

/// Where in the user's input something stands. Line and column count from 1; 0 means unknown.
struct Place {
  std::string file;
  int line = 0;
  int column = 0;
};

/// One thing that is wrong, in the four parts a person needs to mend it.
///
/// Printed as `FILE:LINE:COLUMN: KEY: RULE, found FOUND; REMEDY`; empty parts are left out.
struct Fault {
  Place place;
  std::string key;     ///< dotted path, e.g. `encoders.elbow.bits`, or `joint 'elbow'` in a URDF
  std::string rule;    ///< what is wrong: the rule that was broken
  std::string found;   ///< what was found, quoted where it is the user's text
  std::string remedy;  ///< what would be right
};

/// What kind of trouble an error is; its value is the exit code of the command line.
enum class Trouble { usage = 2, input = 3, file_system = 4, internal = 5 };

/// The one exception type of qerr: it carries every fault found in one piece of input.
class Error : public std::runtime_error {
 public:
  explicit Error(Fault fault, Trouble trouble = Trouble::input);
  explicit Error(std::vector<Fault> faults, Trouble trouble = Trouble::input);
  const std::vector<Fault>& faults() const { return faults_; }
  Trouble trouble() const { return trouble_; }

 private:
  std::vector<Fault> faults_;
  Trouble trouble_;
};

/// One line per fault, control characters escaped, at most 20 lines in all.
std::string format(const std::vector<Fault>& faults);

/// The text with control characters, DEL and invalid UTF-8 written as \xNN, cut to `limit` bytes: safe for a
/// terminal.
std::string escaped(const std::string& text, std::size_t limit = 200);

}  // namespace qerr
