#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bound/error_columns.hpp"
#include "core/output_file.hpp"
#include "core/run_files.hpp"
#include "input/spec_variants.hpp"
#include "qerr/bound/figure.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/report/analysis.hpp"
#include "qerr/report/write.hpp"
#include "report/text_table.hpp"

namespace qerr {

/// Variants whose number is `first` modulo `stride`: shard K of N has first K - 1 and stride N, so that each
/// has its share of every part of the grid.
struct Shard {
  std::uint64_t first = 0, stride = 1;

  std::uint64_t variant(std::uint64_t index) const { return first + index * stride; }
  /// How many of `total` variants it has.
  std::uint64_t size(std::uint64_t total) const {
    return total > first ? (total - first - 1) / stride + 1 : 0;
  }
};

/// A key that varies, as programs read it.
struct SweepColumn {
  std::string key, unit;
  std::size_t axis = 0;
  /// Values of the axis's steps [SI], if all are numbers, in units of one kind; else empty: they are
  /// texts, such as the family of a filter or a row of a catalogue.
  std::vector<double> values;

  std::string header() const { return unit.empty() ? key : key + " [" + unit + ']'; }
};

/// The variants of a sweep, numbered from 0: all combinations of the steps of its axes, of which the first
/// one varies slowest.
class SweepGrid {
 public:
  /// @throws Error (input; key `sweep`) if there is no axis, or more than 2^53 variants
  explicit SweepGrid(const Spec&);

  std::uint64_t count() const { return count_; }
  const std::vector<SweepAxis>& axes() const { return axes_; }

  /// The keys that vary, in the order of the axes.
  std::vector<std::string> keys() const;
  const std::vector<SweepColumn>& columns() const { return columns_; }
  std::vector<std::string> names(std::uint64_t variant) const;
  /// `KEY = VALUE, KEY = VALUE` for messages. @param text  of a value's name
  std::string description(std::uint64_t variant,
                          const std::function<std::string(const std::string&)>& text = std::identity()) const;

  std::vector<std::size_t> steps(std::uint64_t variant) const;
  /// The spec with the chosen steps of the axes. @param steps  as of `steps`
  Spec spec(const SpecVariants&, const std::vector<std::size_t>& steps) const;
  /// Likewise; empty if it has a fault.
  std::optional<Spec> readable(const SpecVariants&, const std::vector<std::size_t>& steps) const;

 private:
  /// A step as changes of the tree.
  struct Changes {
    std::vector<SpecChange> values;
    std::vector<Node> effects;
  };

  std::vector<SweepAxis> axes_;
  std::vector<SweepColumn> columns_;
  std::vector<std::vector<Changes>> changes_;  // [axis][step]
  std::uint64_t count_ = 1;
};

/// A variant of a sweep with its figures; or what is wrong with it, in one line.
struct SweptVariant {
  std::uint64_t variant = 0;
  /// Empty: it cannot be computed. Without results if a requirement cannot be decided. Statistics that were
  /// not asked for are unset.
  std::optional<SpecCheck> check;
  std::string fault;  ///< "" if there is none
};

/// Evaluates variants of a sweep many at a time. Where only encoders, gears, filters, effects, motions and
/// requirements vary, they share the columns of the Jacobian: a variant costs a matrix product in place of
/// the kinematics at all configurations, a quarter of an `analyze` with all statistics.
///
/// Variants share columns if the last axes of the sweep are of this kind and have at least 8 combinations.
/// The others, and those that `have_columns` excludes, are evaluated by `analyze`. Which one it is depends on
/// the spec alone, so that the result does not depend on threads or shards.
class ColumnSweep {
 public:
  /// @param wanted  statistics that are reported; where requirements are judged theirs are computed, too
  ColumnSweep(const SpecVariants&, const SweepGrid&, bool judged, std::vector<const StatisticKind*> wanted,
              unsigned threads);

  /// Variants that are best evaluated together.
  std::size_t batch() const { return shared_ > 1 ? forms_per_tile : 1; }

  /// May be called from several threads.
  /// @param inner_threads  of the evaluation of one variant
  /// @throws Error (file_system)
  std::vector<SweptVariant> evaluate(std::span<const std::uint64_t> variants, unsigned inner_threads) const;

 private:
  /// What the variants of one robot and one set of configurations share.
  struct Shared {
    std::uint64_t group = 0;
    std::unique_ptr<ErrorColumns> columns;  // null: not possible
    std::unique_ptr<ColumnStatistics> statistics;
  };

  std::shared_ptr<const Shared> shared(std::uint64_t group) const;
  std::shared_ptr<const Shared> computed(std::uint64_t group) const;
  std::vector<IndependentError> sources(std::vector<std::size_t> steps) const;
  SweptVariant evaluated(std::uint64_t variant, const WorkspaceOptions&, const Shared*) const;
  void judge(SweptVariant&) const;

  const SpecVariants& variants_;
  const SweepGrid& grid_;
  bool judged_;
  WantedStatistics wanted_;
  unsigned threads_;
  std::size_t first_light_;   // axis from which on variants share columns
  std::uint64_t shared_ = 1;  // variants that share columns
  mutable std::mutex mutex_;
  mutable std::shared_ptr<const Shared> last_;
};

/// The part of a sweep that is to be computed, and how.
struct SweepJob {
  const SpecVariants& variants;
  const SweepGrid& grid;
  Shard shard = {};
  bool judged = false;                           ///< evaluate the requirements, too
  std::vector<const StatisticKind*> statistics;  ///< that the texts have
  unsigned threads = 0;                          ///< 0: one per core; the texts do not depend on it
  /// The text of a variant; called on any thread.
  std::function<std::string(const SweptVariant&)> text;

  std::uint64_t size() const { return shard.size(grid.count()); }
};

/// What became of the variants so far.
struct SweepCounts {
  std::uint64_t variants = 0;
  std::uint64_t failed = 0;    ///< could not be computed, or have a requirement that cannot be decided
  std::uint64_t unmet = 0;     ///< do not meet their requirements
  std::uint64_t unjudged = 0;  ///< whose requirements were not evaluated
};

struct SweepOutcome {
  SweepCounts counts;
  std::vector<std::string> faults;  ///< of some variants that failed: number, values and fault
};

/// What became of a variant, as one letter: `e` it failed, `n` it does not meet its requirements, `y` it
/// does, `u` they were not evaluated.
char verdict_of(const SweptVariant&, bool judged);
/// Counts a variant by that letter. @returns false for another letter
bool count_verdict(SweepCounts&, char verdict);

/// Evaluates the variants of a job, and passes on their texts in order, each as soon as those before it have
/// been. Memory does not grow with the number of variants.
/// @param before    the variants of the job that are not computed: the first ones
/// @param write     called with the texts of some variants, and the counts up to them
/// @param progress  called with the number of variants of the job that are done; may be empty
SweepOutcome run_sweep(const SweepJob&, const SweepCounts& before,
                       const std::function<void(const std::string&, const SweepCounts&)>& write,
                       const std::function<void(std::uint64_t done, std::uint64_t total)>& progress = {});

/// How a sweep is written as CSV: a header, and the lines of each variant, which depend on nothing else.
struct SweepRows {
  std::string header;  ///< without the end of the line
  /// Lines, each with its "\r\n".
  std::function<std::string(const SweptVariant&)> lines;
};

/// One row a figure: the variant, its keys, and the columns of an analysis in CSV. A variant that cannot be
/// computed has one row with the signal `error` and the fault in the column `bound`.
/// @param grid  must outlive the rows, as in all functions below
SweepRows tidy_rows(const SweepGrid& grid, std::vector<const StatisticKind*> statistics);

/// One row a variant: its keys, every figure, the norms and other figures of its filters, its requirements
/// with their verdict, and its fault.
///
/// The columns are those of the first variant that can be read, and of the variants that differ from it in
/// one step. @throws Error (input; key `sweep`) from `lines` for a variant with further columns
SweepRows wide_rows(const SweepGrid& grid, const SpecVariants&, std::vector<const StatisticKind*> statistics);

/// A sweep as JSON: the texts before, between and after those of its variants.
struct SweepJson {
  std::string begin, separator, end;
  static std::string variant(const SweptVariant&, const SweepGrid&, const std::vector<const StatisticKind*>&);
};
SweepJson sweep_json(const SpecVariants&, const SweepGrid&);

/// A dotted path in words that a narrow column can break.
std::string in_words(std::string path);

/// A sweep as a table: one line a variant, with the requirements' values, or else the largest worst case of
/// every coordinate and the largest sigma behind every filter.
class SweepTable {
 public:
  SweepTable(const SpecVariants&, const SweepGrid&);

  /// The cells of a variant, to be given to `add` in order; called on any thread.
  std::vector<std::string> row(const SweptVariant&) const;
  void add(std::vector<std::string> row) { cells_.push_back(std::move(row)); }
  std::string text(const Style&) const;

 private:
  std::vector<std::string> figures(const SpecCheck&) const;

  const SpecVariants& variants_;
  const SweepGrid& grid_;
  TableRows cells_;
};

/// The key of a sweep whose values are numbers of one dimension: what figures are drawn over.
struct SweepAbscissa {
  std::size_t axis = 0;
  std::string key, unit;
  std::vector<double> values;      ///< of the axis' steps [SI]
  std::vector<std::size_t> order;  ///< steps by ascending value
  bool logarithmic = false;        ///< equally spaced in the logarithm
};

/// Which variants of a sweep a page draws: it depends on the grid alone, so that the same ones are drawn
/// whatever the threads.
struct DrawnVariants {
  /// The variants of one combination of the other keys, by ascending value of the abscissa.
  struct Line {
    std::string name;
    std::vector<std::uint64_t> variants;
  };

  std::optional<SweepAbscissa> abscissa;  ///< empty: one bar a variant, in a single line
  std::vector<Line> lines;
  std::uint64_t lines_in_all = 1;  ///< combinations of the other keys
  std::size_t points_in_all = 0;   ///< of a line

  double value(const SweepGrid&, std::uint64_t variant) const;
};

/// A sweep as a page: its requirements' values, the largest worst case of every coordinate and the largest
/// sigma behind every filter, over each key that has numbers, one line for each combination of the others.
///
/// What is kept does not grow with the number of variants beyond what is drawn.
class SweepPage {
 public:
  SweepPage(const SpecVariants&, const SweepGrid&);

  /// The figures of a variant, NaN where it has none.
  struct VariantFigures {
    char verdict = '-';         ///< of its requirements: y met, n not, - not judged
    bool other_limits = false;  ///< its requirements are not those of the spec
    std::vector<double> values = {};
  };

  /// The figures of a variant, to be given to `add` in order; called on any thread.
  VariantFigures row(const SweptVariant&) const;
  void add(const VariantFigures&);
  std::string text(const SweepOutcome&) const;

 private:
  struct SweptQuantity {
    std::string name, unit;
    std::ptrdiff_t requirement = -1;  ///< of the spec; -1: a figure by its name
  };
  struct Extreme {
    double value = 0;
    std::uint64_t variant = 0;
  };

  void add_figures();
  std::optional<double> tightest(const VariantFigures&) const;
  const Requirement* required(const SweptQuantity&) const;
  double value(std::size_t figure, std::uint64_t variant) const;
  std::string answer() const;
  std::string picture(std::size_t figure, const DrawnVariants&) const;
  std::string plot(std::size_t figure, const DrawnVariants&) const;
  std::string matrix(std::size_t figure, const DrawnVariants&) const;
  std::string bars(std::size_t figure, const DrawnVariants&) const;
  std::string what_is_drawn(const DrawnVariants&) const;
  std::string table() const;

  const SpecVariants& variants_;
  const SweepGrid& grid_;
  std::vector<SweptQuantity> figures_;
  std::vector<DrawnVariants> drawn_;
  std::map<std::uint64_t, VariantFigures>
      kept_;                ///< rows that are drawn or in the table; empty until they are added
  std::uint64_t next_ = 0;  ///< number of the variant that is added next
  std::uint64_t met_ = 0, judged_ = 0;
  std::vector<std::optional<Extreme>> least_, largest_;  ///< of every figure
  std::optional<Extreme> best_;                          ///< that uses the least part of its tightest limit
  bool limits_vary_ = false;                             ///< the sweep changes a requirement
};

/// What the rows of a sweep depend on: the version of qerr, the spec, the files that it names, the options,
/// and the number of variants, each with its value or a fingerprint (16 digits of SHA-256).
///
/// Rows of one record may stand in one file; `difference` names what keeps two records apart.
class RunRecord {
 public:
  RunRecord() = default;
  /// @param options  names and values of those on which the rows depend
  /// @throws Error (file_system) for a file of a step that cannot be read
  RunRecord(const SpecVariants&, const SweepGrid&,
            const std::vector<std::pair<std::string, std::string>>& options);
  /// Reads `text()` back.
  explicit RunRecord(std::string_view text);

  /// One line without commas and quotation marks: `NAME=VALUE; NAME=VALUE`, sorted.
  std::string text() const;
  /// The names of the entries in which the records differ, for messages; "" if they agree.
  std::string difference(const RunRecord& other) const;
  /// The value of an entry; "" if there is none.
  std::string value(std::string_view name) const;

 private:
  std::vector<std::pair<std::string, std::string>> entries_;  // sorted
};

/// What ends a line of the CSV that qerr writes; no cell has one.
inline constexpr std::string_view csv_line_break = "\r\n";

/// The lines of a file that qerr has written, one after the other; a file is never held whole.
class CsvLines {
 public:
  /// Up to `most` bytes from a position; none only at the end.
  using Read = std::function<std::string(std::uint64_t from, std::size_t most)>;

  explicit CsvLines(Read read) : read_(std::move(read)) {}

  /// @returns false at the end
  bool next();
  std::string_view line() const { return line_; }   ///< without its line break; valid until `next`
  bool ended() const { return ended_; }             ///< it has a line break
  std::uint64_t begin() const { return begin_; }    ///< its position in the file
  std::uint64_t number() const { return number_; }  ///< from 1

 private:
  Read read_;
  std::string buffer_;  // of the file from start_ on
  std::uint64_t start_ = 0;
  std::size_t at_ = 0;  // of the next line
  std::string_view line_;
  std::uint64_t begin_ = 0, number_ = 0;
  bool ended_ = false;
};

/// The first line of a shard. Its last cell says which shard it is, and of which sweep:
/// `shard 2/5; NAME=VALUE; ...`, where the record follows the number.
struct ShardHeader {
  std::string columns;  ///< without that cell
  std::string mark;     ///< that cell
  Shard shard;
  RunRecord record;
};
std::string shard_mark(const Shard&, const RunRecord&);

/// The lines of a variant as a shard has them: with one more cell, which is empty but in the last line. There
/// it is the verdict (run_sweep.hpp) and a checksum of it, the lines and the mark of the shard.
std::string marked_lines(const std::string& lines, char verdict, const std::string& mark);

/// The variants of a shard, one after the other.
class ShardLines {
 public:
  explicit ShardLines(CsvLines::Read read) : lines_(std::move(read)) {}

  /// Reads the first line; to be called once, first. @returns empty if it is not that of a shard
  const std::optional<ShardHeader>& read_header();
  /// Whether the first line has its line break, later the last one that was read.
  bool ended() const { return lines_.ended(); }

  /// Reads the next variant. @returns false at the end
  bool next();
  /// Whether it is as it was written. @pre for all functions below
  bool whole() const { return whole_; }
  std::uint64_t variant() const { return variant_; }
  char verdict() const { return verdict_; }
  const std::string& text() const { return text_; }         ///< its lines, without the last cells
  std::uint64_t end() const { return end_; }                ///< position of the line break behind it
  std::uint64_t number() const { return lines_.number(); }  ///< of its last line

 private:
  CsvLines lines_;
  std::optional<ShardHeader> header_;
  std::string text_;
  std::uint64_t variant_ = 0, end_ = 0;
  char verdict_ = 0;
  bool whole_ = false;
};

/// Joins the files of all shards of a sweep, each of which is read once: it may be a pipe.
/// @param expected  the record of the sweep of which they must be; null: they are compared with each other
/// @param write     is called with the bytes that one run would have written, in order
/// @returns the counts of all variants
/// @throws Error (input) naming the files, if one is torn, changed, given twice or of another sweep, or if
/// one is missing; (file_system) if one cannot be read
SweepCounts merge_shards(const std::vector<std::string>& files, const RunRecord* expected,
                         const std::function<void(const std::string&)>& write);

/// CSV of a sweep that grows by the lines of one variant after the other, and can be continued.
///
/// The last line has no line break until the file is complete: whatever ends the process, a file that ends
/// with a line break is whole, and one that does not is not. From time to time the file is synchronized.
///
/// What keeps rows of two sweeps apart is the record of the run (shards.hpp). A shard, which is a file
/// for `qerr merge`, has it in its last column (shards.hpp). The table of a whole sweep is for its reader:
/// its record, with a checksum of the bytes so far, is a note of the file (core/output_file.hpp). Where that
/// is lost, all variants are computed anew.
class ShardFile {
 public:
  /// @param header  without a line break
  /// @param marked  each variant ends with its checksum: the file of a shard
  /// @param keep    continue what the file holds (`resume`); else it is emptied and the header written
  ShardFile(const std::string& path, const std::string& option, std::string header, const RunRecord& record,
            bool marked, bool keep);

  /// Keeps the variants that the file holds unchanged.
  /// @param judged  keep none whose requirements were not evaluated
  /// @returns those that are kept; the following ones are to be written
  /// @throws Error (input), which names what differs, if the file is of another sweep
  SweepCounts resume(bool judged);
  /// Whether nothing said of which sweep the rows were that the file held.
  bool unknown() const { return unknown_; }
  /// Whether rows that the file held, damaged or edited, were replaced.
  bool replaces() const { return replaces_; }

  /// Appends the lines of the next variants, each with its line break.
  /// @param counts  of all variants up to these
  void write(std::string_view lines, const SweepCounts& counts);
  void close();

 private:
  SweepCounts resume_marked(bool judged);
  SweepCounts resume_noted(bool judged);
  void begin_anew();
  void refuse_other(const RunRecord& held) const;
  [[noreturn]] void refuse(const std::string& rule, const std::string& found, std::uint64_t line,
                           const std::string& remedy) const;
  void put(std::string_view text);
  void store_note(const SweepCounts&);

  GrowingFile file_;
  std::string header_;
  RunRecord record_;
  bool marked_;
  bool replaces_ = false;
  bool unknown_ = false;
  Sha256 sum_;  ///< of all bytes up to the end
  std::uint64_t size_ = 0;
  SweepCounts counts_;  ///< of what is written
  std::chrono::steady_clock::time_point noted_, synchronized_;
};

}  // namespace qerr
