#include "filter/norms/tail_sum.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "filter/norms/resonance_sum.hpp"
#include "filter/norms/sign_runs.hpp"

namespace qerr {
namespace {

constexpr double negligible = 1e-18;  // of the norm: what a mode still adds when it is left out
constexpr double blocks_per_run = 4;  // at least, for a run of an oscillation
constexpr double many_runs = 300;     // beyond, shedding modes pays
constexpr std::int64_t longest = std::int64_t{1} << 50;

/// sum over k >= from of what one mode adds.
double tail(const Mode& mode, const Powers& powers, std::int64_t from) {
  return Sequence({mode}, powers).tail(from);
}

/// From when on a mode is negligible, but for a quarter of the time.
std::int64_t death(const Mode& mode, std::int64_t from, double scale) {
  const Powers powers({mode});
  std::int64_t end = from + 16;
  while (end < longest && !(tail(mode, powers, end) <= negligible * scale)) end += end / 4;
  return end;
}

/// About how often the modes change sign over from..end.
double runs_of(const std::vector<Mode>& modes, std::int64_t from, std::int64_t end) {
  double fastest = 0;
  for (const Mode& m : modes) {
    if (m.pair) fastest = std::max(fastest, std::abs(std::atan2(m.z.im.mid().hi, m.z.re.mid().hi)));
  }
  return fastest * static_cast<double>(end - from) / std::numbers::pi;
}

/// Takes the dead modes out; returns what they still add.
double shed(std::vector<Mode>& modes, std::vector<std::int64_t>& deaths, std::int64_t from) {
  double left_out = 0;
  for (std::size_t i = modes.size(); i-- > 0;) {
    if (deaths[i] > from) continue;
    left_out += tail(modes[i], Powers({modes[i]}), from);
    modes.erase(modes.begin() + static_cast<std::ptrdiff_t>(i));
    deaths.erase(deaths.begin() + static_cast<std::ptrdiff_t>(i));
  }
  return left_out;
}

bool one_resonance(const std::vector<Mode>& modes) {
  return modes.size() == 1 && modes[0].pair && modes[0].c.size() == 1;
}

/// Where there are too many runs: the turns of the slowest mode, if it is a resonance, which the others can
/// only change by their own sum.
TailSum bounded(const std::vector<Mode>& modes, std::int64_t from, std::int64_t end, const Sequence& x) {
  const auto slowest = std::min_element(modes.begin(), modes.end(), [](const Mode& a, const Mode& b) {
    return one_minus_modulus(a.one_minus_z) < one_minus_modulus(b.one_minus_z);
  });
  if (!one_resonance({*slowest}) || !x.trusted()) return {{}, 0, x.tail(from)};
  std::vector<Mode> others(modes.begin(), slowest);
  others.insert(others.end(), slowest + 1, modes.end());
  return {resonance_sum(*slowest, from, end), Sequence(others, Powers(others)).tail(from),
          tail(*slowest, Powers({*slowest}), end)};
}

TailSum add(TailSum x, const TailSum& y) {
  x.sum += y.sum;
  x.error += y.error;
  x.beyond += y.beyond;
  return x;
}

}  // namespace

TailSum tail_sum(std::vector<Mode> modes, std::int64_t from, double scale, std::int64_t work) {
  std::vector<std::int64_t> deaths;
  for (const Mode& m : modes) deaths.push_back(death(m, from, scale));
  TailSum r;
  while (!modes.empty()) {
    const Powers powers(modes);
    const Sequence x(modes, powers);
    const std::int64_t end = *std::max_element(deaths.begin(), deaths.end());
    std::int64_t until = end;
    if (runs_of(modes, from, end) > many_runs) {
      if (one_resonance(modes)) return add(r, bounded(modes, from, end, x));
      until = std::min(end, std::max(*std::min_element(deaths.begin(), deaths.end()), 2 * from));
    }
    const auto count = static_cast<std::int64_t>(modes.size());
    const double needed = blocks_per_run * runs_of(modes, from, until) * static_cast<double>(count);
    if (!x.trusted() || needed > static_cast<double>(work)) return add(r, bounded(modes, from, end, x));
    const RunsSum s = sum_of_runs(x, powers, scale, from, until, work / count);
    work = s.visits * count;
    r.sum += s.sum;
    r.error += s.error;
    from = s.next;
    if (from < until || until == end) {
      r.beyond = x.tail(from);
      return r;
    }
    r.error += shed(modes, deaths, from);
  }
  return r;
}

std::int64_t slowest_alone_from(const std::vector<Mode>& modes, std::int64_t from, std::int64_t latest,
                                double scale) {
  std::vector<std::int64_t> deaths;
  for (const Mode& m : modes) deaths.push_back(death(m, from, scale));
  std::sort(deaths.begin(), deaths.end());
  const std::int64_t last_but_one = deaths.size() > 1 ? deaths[deaths.size() - 2] : from;
  return std::max(from, std::min(last_but_one, latest));
}

}  // namespace qerr
