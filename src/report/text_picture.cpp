#include <algorithm>
#include <cmath>
#include <limits>

#include "core/text.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

constexpr int most_rows = 10;
constexpr std::size_t most_columns = 72;  // a wider picture shows no more of some fifty bins
constexpr std::size_t least_columns = 12;
constexpr double tick_distance = 8;  // columns between the ticks of the abscissa

struct Glyphs {
  const char *point, *line, *both, *rise, *axis, *tick, *corner, *across, *across_tick;
};
constexpr Glyphs unicode_glyphs{"•", "─", "●", "│", "│", "┤", "└", "─", "┬"};
constexpr Glyphs ascii_glyphs{"o", "-", "*", "|", "|", "+", "+", "-", "+"};

struct ValueRange {
  double least = std::numeric_limits<double>::infinity();
  double most = -std::numeric_limits<double>::infinity();

  void add(double value) {
    if (!std::isfinite(value)) return;
    least = std::min(least, value);
    most = std::max(most, value);
  }
};

/// The ordinate of row k, counted from zero upwards, is k * tick / rows_per_tick.
struct Ordinate {
  double tick = 1;
  int rows_per_tick = 2;
  int lowest = 0, highest = 0;

  double per_row() const { return tick / rows_per_tick; }
  int row(double value) const { return static_cast<int>(std::lround(value / per_row())); }
};

/// The finest ordinate with a round tick every second to fifth row on which the range fits. Successive values
/// per row differ by a third at most, so that at least eight of the rows are used.
Ordinate ordinate(const ValueRange& range) {
  constexpr double round[] = {1, 2, 2.5, 5};
  const double least = (range.most - range.least) / most_rows;
  const double decade = std::pow(10, std::floor(std::log10(least)) - 1);
  Ordinate best;
  double finest = std::numeric_limits<double>::infinity();
  for (double power = decade; power < 1e4 * decade; power *= 10)
    for (const double digit : round)
      for (int rows = 2; rows <= 5; ++rows) {
        Ordinate o{digit * power, rows};
        o.lowest = o.row(range.least);
        o.highest = o.row(range.most);
        if (o.highest - o.lowest >= most_rows || !(o.per_row() < finest)) continue;
        finest = o.per_row();
        best = o;
      }
  return best;
}

/// Mean of the finite values of every column.
std::vector<double> column_means(const TextPicture& p, const std::vector<double>& values,
                                 std::size_t columns) {
  std::vector<double> sum(columns), count(columns);
  const double span = p.at.back() - p.at.front();
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    const auto column = static_cast<std::size_t>(
        std::lround((p.at[i] - p.at.front()) / span * static_cast<double>(columns - 1)));
    sum[column] += values[i];
    count[column] += 1;
  }
  for (std::size_t c = 0; c < columns; ++c) sum[c] = count[c] > 0 ? sum[c] / count[c] : std::nan("");
  return sum;
}

/// The line at every column: interpolated between finite neighbours in the list, NaN in a gap.
std::vector<double> interpolated(const TextPicture& p, std::size_t columns) {
  std::vector<double> values = column_means(p, p.line, columns);
  const double span = p.at.back() - p.at.front();
  std::size_t right = 1;
  for (std::size_t c = 0; c < columns; ++c) {
    const double at = p.at.front() + span * static_cast<double>(c) / static_cast<double>(columns - 1);
    while (right + 1 < p.at.size() && p.at[right] < at) ++right;
    const double length = p.at[right] - p.at[right - 1];
    if (!std::isfinite(values[c]) && right < p.line.size())
      values[c] = p.line[right - 1] +
                  (p.line[right] - p.line[right - 1]) * (length > 0 ? (at - p.at[right - 1]) / length : 0);
  }
  return values;
}

using Canvas = TableRows;  // rows from the lowest, of cells

void draw_line(Canvas& canvas, const std::vector<double>& values, const Ordinate& o, const Glyphs& glyphs) {
  for (std::size_t c = 0; c < values.size(); ++c) {
    if (!std::isfinite(values[c])) continue;
    const int row = o.row(values[c]) - o.lowest;
    canvas[row][c] = glyphs.line;
    if (c == 0 || !std::isfinite(values[c - 1])) continue;
    const int before = o.row(values[c - 1]) - o.lowest;
    for (int k = std::min(row, before) + 1; k < std::max(row, before); ++k) canvas[k][c] = glyphs.rise;
  }
}

void draw_points(Canvas& canvas, const std::vector<double>& values, const Ordinate& o, const Glyphs& glyphs) {
  for (std::size_t c = 0; c < values.size(); ++c) {
    if (!std::isfinite(values[c])) continue;
    std::string& cell = canvas[o.row(values[c]) - o.lowest][c];
    cell = cell == " " ? glyphs.point : glyphs.both;
  }
}

/// A multiple of a round tick; small sums of rounding errors are zero.
std::string tick_label(int multiple, double tick) { return significant(multiple * tick, 6); }

std::vector<std::string> row_labels(const Ordinate& o) {
  std::vector<std::string> labels;
  for (int k = o.lowest; k <= o.highest; ++k)
    labels.push_back(k % o.rows_per_tick == 0 ? tick_label(k / o.rows_per_tick, o.tick) : "");
  return labels;
}

/// The line below the rows, and its labels, without those that would touch another one.
std::pair<std::string, std::string> abscissa(const TextPicture& p, std::size_t columns,
                                             const Glyphs& glyphs) {
  const double from = p.at.front(), span = p.at.back() - from;
  const double tick = round_step(span * tick_distance / static_cast<double>(columns));
  std::vector<std::string> marks(columns, glyphs.across);
  std::string labels;
  for (double k = std::ceil(from / tick - 1e-9); k * tick <= p.at.back() + 1e-9 * tick; ++k) {
    const double place = (k * tick - from) / span * static_cast<double>(columns - 1);
    const auto column = std::min(columns - 1, static_cast<std::size_t>(std::lround(std::max(place, 0.0))));
    const std::string label = tick_label(static_cast<int>(k), tick);
    const std::size_t begin = column - std::min(column, label.size() / 2);
    marks[column] = glyphs.across_tick;
    if (begin < labels.size() + (labels.empty() ? 0 : 1) || begin + label.size() > columns + 1) continue;
    labels += std::string(begin - labels.size(), ' ') + label;
  }
  std::string line;
  for (const std::string& mark : marks) line += mark;
  return {line, labels};
}

std::string legend(const TextPicture& p, const Glyphs& glyphs) {
  std::string text = p.ordinate + " against " + p.abscissa + ": " + glyphs.point + " " + p.points_name;
  if (!p.line.empty())
    text += std::string(", ") + glyphs.line + " " + p.line_name + ", " + glyphs.both + " both";
  return text;
}

ValueRange range_of(const TextPicture& p) {
  ValueRange range;
  range.add(0);
  for (const double value : p.points) range.add(value);
  for (const double value : p.line) range.add(value);
  return range;
}

}  // namespace

double round_step(double least, double tolerance) {
  const double power = std::pow(10, std::floor(std::log10(least)));
  for (const double digit : {1.0, 2.0, 5.0})
    if (digit * power >= least * (1 - tolerance)) return digit * power;
  return 10 * power;
}

std::string text_picture(const TextPicture& p, const Style& style, const std::string& indent) {
  const auto finite = std::ranges::count_if(p.points, [](double v) { return std::isfinite(v); });
  const ValueRange range = range_of(p);
  if (finite < 2 || !(p.at.back() > p.at.front()) || !(range.most > range.least)) return "";
  const Glyphs& glyphs = style.ascii ? ascii_glyphs : unicode_glyphs;
  const Ordinate o = ordinate(range);
  const std::vector<std::string> labels = row_labels(o);
  std::size_t margin = 0;
  for (const std::string& label : labels) margin = std::max(margin, label.size());
  const std::size_t used = indent.size() + margin + 2;  // a blank and the axis
  const std::size_t columns =
      std::min(most_columns, style.width > used + least_columns ? style.width - used : least_columns);
  Canvas canvas(labels.size(), std::vector<std::string>(columns, " "));
  draw_line(canvas, interpolated(p, columns), o, glyphs);
  draw_points(canvas, column_means(p, p.points, columns), o, glyphs);

  std::string out = wrapped(legend(p, glyphs), style.width, indent);
  for (std::size_t k = labels.size(); k-- > 0;) {
    std::string line = indent + std::string(margin - labels[k].size(), ' ') + labels[k] + ' ' +
                       (labels[k].empty() ? glyphs.axis : glyphs.tick);
    for (const std::string& cell : canvas[k]) line += cell;
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + '\n';
  }
  const auto [line, names] = abscissa(p, columns, glyphs);
  const std::string below = indent + std::string(margin + 1, ' ');
  return out + below + glyphs.corner + line + '\n' + below + ' ' + names + '\n';
}

}  // namespace qerr
