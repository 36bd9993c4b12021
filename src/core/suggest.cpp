#include "core/suggest.hpp"

#include <algorithm>
#include <cctype>
#include <numeric>

namespace qerr {

namespace {

/// Edit distance with transpositions (optimal string alignment distance), not case-sensitive.
std::size_t distance(std::string_view a, std::string_view b) {
  const auto same = [](char x, char y) {
    return std::tolower(static_cast<unsigned char>(x)) == std::tolower(static_cast<unsigned char>(y));
  };
  std::vector<std::size_t> before(b.size() + 1), row(b.size() + 1), next(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    next[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      next[j] = std::min({row[j] + 1, next[j - 1] + 1, row[j - 1] + (same(a[i - 1], b[j - 1]) ? 0 : 1)});
      if (i > 1 && j > 1 && same(a[i - 1], b[j - 2]) && same(a[i - 2], b[j - 1]))
        next[j] = std::min(next[j], before[j - 2] + 1);
    }
    before = row;
    row = next;
  }
  return row[b.size()];
}

}  // namespace

namespace {

/// The known names at the smallest distance, if that is one letter or a third of the shorter word at most:
/// `mean` is not near `median`.
std::vector<std::string> all_nearest(std::string_view word, const std::vector<std::string>& known) {
  std::vector<std::string> best;
  if (word.empty() || word.size() > 64) return best;
  std::size_t least = word.size();
  for (const std::string& name : known) {
    const bool begins = word.size() >= 3 && name.starts_with(word);
    const std::size_t d = begins ? std::min<std::size_t>(distance(word, name), 1) : distance(word, name);
    const std::size_t shorter = std::min(word.size(), name.size());
    if (!begins && (d > std::max<std::size_t>(1, shorter / 3) || d >= shorter)) continue;
    if (d > least) continue;
    if (d < least) best.clear();
    least = d;
    best.push_back(name);
  }
  return best;
}

}  // namespace

std::string nearest(std::string_view word, const std::vector<std::string>& known) {
  const std::vector<std::string> best = all_nearest(word, known);
  return best.empty() ? "" : best.front();
}

std::string did_you_mean(std::string_view word, const std::vector<std::string>& known) {
  constexpr std::size_t most_suggestions = 2;
  const std::vector<std::string> near = all_nearest(word, known);
  if (!near.empty() && near.size() <= most_suggestions)
    return "did you mean '" + near.front() + "'" + (near.size() > 1 ? " or '" + near.back() + "'" : "") + "?";
  std::string text = "known: ";
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (i == 12) return text + ", ...";
    text += (i ? ", " : "") + known[i];
  }
  return known.empty() ? "no name is allowed here" : text;
}

}  // namespace qerr
