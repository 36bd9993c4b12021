#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace qerr {

/// How the lines of a table are laid out around its cells: as JSON objects, as `t=0.1 counts=12`, between
/// brackets or pipes, behind `17:16:42.123 -> `, or ended by carriage returns alone. `plain` makes cells of
/// them in place: what is no cell becomes a blank, so that the column of every cell stays what it is in the
/// file.
class LineLayout {
 public:
  LineLayout() = default;
  /// Recognizes the layout of a text by its first lines.
  explicit LineLayout(std::string_view head);

  bool is_plain() const { return !returns_ && labels_.empty() && !framed_ && arrow_ == '\0'; }
  /// The labels of the cells, which every line repeats: the header that the table does not have.
  const std::vector<std::string>& labels() const { return labels_; }
  /// "labels before the values", for a report; "" if it is plain.
  std::string description() const;
  /// The character by which lines end.
  char line_end() const { return returns_ ? '\r' : '\n'; }

  /// Makes a line, its end included, one of cells.
  void make_plain(char* begin, char* end) const;

 private:
  bool returns_ = false;  ///< lines end with a carriage return
  bool framed_ = false;   ///< in brackets or pipes
  char arrow_ = '\0';     ///< what takes the place of `->`
  std::vector<std::string> labels_;
};

}  // namespace qerr
