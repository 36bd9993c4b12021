#include "filter/norms/tail_sum.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "filter/norms/resonance_sum.hpp"
#include "filter/norms/sampled_sum.hpp"
#include "filter/norms/sign_runs.hpp"

namespace qerr {
namespace {

constexpr double negligible_tail = 1e-18;  // remaining sum of a dropped mode relative to the norm
constexpr double blocks_per_run = 8;       // of an oscillation, its sums included
constexpr double samples_per_block = 300;  // that sampled_sum takes in the time of a block
constexpr double narrow = 1e-13;           // error of a sampled sum relative to the norm
constexpr double many_runs = 300;          // above, dropping decayed modes saves time
constexpr std::int64_t longest = latest_sample / 2;

/// A sample from which a mode is negligible_tail, at most a quarter later than the first one.
std::int64_t end_of(const Mode& mode, std::int64_t from, double scale) {
  std::int64_t end = from + 16;
  while (end < longest && !(tail(mode, end) <= negligible_tail * scale)) end += end / 4;
  return end;
}

/// Approximate number of sign changes of the modes over from..end.
double runs_of(const std::vector<Mode>& modes, std::int64_t from, std::int64_t end) {
  double fastest = 0;
  for (const Mode& m : modes) fastest = std::max(fastest, angle(m.z));
  return fastest * static_cast<double>(end - from) / std::numbers::pi;
}

/// Removes the modes that have decayed. @returns a bound of their remaining sum
double drop_decayed(std::vector<Mode>& modes, std::vector<std::int64_t>& ends, std::int64_t from) {
  double dropped = 0;
  for (std::size_t i = modes.size(); i-- > 0;) {
    if (ends[i] > from) continue;
    dropped += tail(modes[i], from);
    modes.erase(modes.begin() + static_cast<std::ptrdiff_t>(i));
    ends.erase(ends.begin() + static_cast<std::ptrdiff_t>(i));
  }
  return dropped;
}

bool one_resonance(const std::vector<Mode>& modes) {
  return modes.size() == 1 && modes[0].pair && modes[0].c.size() == 1;
}

bool simple(const std::vector<Mode>& modes) {
  return std::all_of(modes.begin(), modes.end(), [](const Mode& m) { return m.c.size() == 1; });
}

/// For too many runs: the sum of the slowest mode, if it is a resonance; the others change it by at most
/// their own sum.
TailSum bounded(const std::vector<Mode>& modes, std::int64_t from, std::int64_t end, const Sequence& x) {
  const auto slowest = std::min_element(modes.begin(), modes.end(), [](const Mode& a, const Mode& b) {
    return one_minus_modulus(a.one_minus_z) < one_minus_modulus(b.one_minus_z);
  });
  if (!one_resonance({*slowest}) || !x.accurate()) return {{}, 0, x.tail(from)};
  std::vector<Mode> others(modes.begin(), slowest);
  others.insert(others.end(), slowest + 1, modes.end());
  double beside = 0;
  for (const Mode& m : others) beside += tail(m, from);
  return {resonance_sum(*slowest, from, end), beside, tail(*slowest, end)};
}

}  // namespace

TailSum operator+(TailSum x, const TailSum& y) {
  x.sum += y.sum;
  x.error += y.error;
  x.beyond += y.beyond;
  return x;
}

TailSum tail_sum(std::vector<Mode> modes, std::int64_t from, double scale, std::int64_t work) {
  std::vector<std::int64_t> ends;
  for (const Mode& m : modes) ends.push_back(end_of(m, from, scale));
  TailSum r;
  while (!modes.empty()) {
    const std::size_t before = modes.size();
    const Powers powers(modes);
    const Sequence x(modes, powers);
    while (modes.size() == before) {
      const std::int64_t end = *std::max_element(ends.begin(), ends.end());
      std::int64_t until = end;
      if (runs_of(modes, from, end) > many_runs) {
        if (one_resonance(modes)) return r + bounded(modes, from, end, x);
        until = std::min(end, std::max(*std::min_element(ends.begin(), ends.end()), 2 * from));
      }
      const auto count = static_cast<std::int64_t>(modes.size());
      const double by_runs = blocks_per_run * runs_of(modes, from, until) * static_cast<double>(count);
      const double by_samples =
          static_cast<double>(until - from) / samples_per_block * static_cast<double>(count);
      const bool precise = sampling_error * x.tail(from) <= narrow * scale;
      if (!x.accurate()) return r + bounded(modes, from, end, x);
      if (simple(modes) && (by_runs > static_cast<double>(work) || (precise && by_samples < by_runs))) {
        const auto most = static_cast<std::int64_t>(samples_per_block * static_cast<double>(work / count));
        const std::int64_t stop = std::min(until, from + most);
        const SampledSum s = sampled_sum(modes, powers, from, stop);
        work -= static_cast<std::int64_t>(by_samples);
        r.sum += RealBall(s.sum);
        r.error += s.error;
        from = stop;
      } else if (by_runs <= static_cast<double>(work)) {
        const RunsSum s = sum_of_runs(x, powers, scale, from, until, work / count);
        work = s.visits * count;
        r.sum += s.sum;
        r.error += s.error;
        from = s.next;
      }
      if (until == end && from == end) {
        r.beyond = x.tail(from);
        return r;
      }
      if (from < until) return r + bounded(modes, from, end, x);
      r.error += drop_decayed(modes, ends, from);
    }
  }
  return r;
}

// The changes of sign of x_{step k + offset}, over all offsets, are about max_i |arg z_i^step| end_i/pi.
std::int64_t decimation(const std::vector<Mode>& modes, std::int64_t from, double scale) {
  constexpr std::int64_t most = 240;
  // For the tables of powers, which are computed again when a mode has decayed.
  const double blocks_per_part = 2500 * static_cast<double>(modes.size() * (modes.size() + 1));
  struct Ringing {
    FineComplex z;
    double end;
  };
  std::vector<Ringing> ringing;
  for (const Mode& m : modes) ringing.push_back({m.z, static_cast<double>(end_of(m, from, scale))});
  const auto slowest = std::max_element(ringing.begin(), ringing.end(),
                                        [](const Ringing& x, const Ringing& y) { return x.end < y.end; });
  if (slowest != ringing.end() &&
      one_resonance({modes[static_cast<std::size_t>(slowest - ringing.begin())]})) {
    // Alone it is summed in closed form: its changes of sign count while there are others.
    slowest->end = 0;
    for (std::size_t i = 0; i < modes.size(); ++i) slowest->end = std::max(slowest->end, ringing[i].end);
  }
  std::vector<FineComplex> powers(ringing.size(), FineComplex(1.0));
  std::int64_t best = 1;
  double least = std::numeric_limits<double>::infinity();
  for (std::int64_t step = 1; step <= most; ++step) {
    double blocks = blocks_per_part * static_cast<double>(step), runs = 0;
    for (std::size_t i = 0; i < ringing.size(); ++i) {
      powers[i] = powers[i] * ringing[i].z;
      runs = std::max(runs, angle(powers[i]) * ringing[i].end / std::numbers::pi);
    }
    blocks += blocks_per_run * runs;
    if (blocks < least) best = step;
    least = std::min(least, blocks);
    if (least <= blocks_per_part * static_cast<double>(step + 1)) break;
  }
  return best;
}

}  // namespace qerr
