#include "polynomial.hpp"

#include <algorithm>
#include <limits>
#include <numbers>

namespace qerr {
namespace {

constexpr int max_sweeps = 400;

struct Evaluation {
  WideComplex value;
  WideComplex slope;
  double scale = 0;  // sum |c_k| |z|^(n-k): what rounding is measured against
};

Evaluation evaluate(const std::vector<Wide>& descending, WideComplex z) {
  Evaluation e;
  const double m = magnitude(z);
  for (const Wide& c : descending) {
    e.slope = e.slope * z + e.value;
    e.value = e.value * z + WideComplex(c);
    e.scale = e.scale * m + std::abs(c.hi);
  }
  return e;
}

std::vector<WideComplex> first_guess(const std::vector<Wide>& descending) {
  const std::size_t n = descending.size() - 1;
  const double radius = std::exp(
      (std::log(std::abs(descending[n].hi)) - std::log(std::abs(descending[0].hi))) / static_cast<double>(n));
  std::vector<WideComplex> z(n);
  for (std::size_t k = 0; k < n; ++k) {
    // The odd angle keeps the guesses off every symmetry of the polynomial.
    const double angle = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(n) + 0.4;
    z[k] = {Wide(radius * std::cos(angle)), Wide(radius * std::sin(angle))};
  }
  return z;
}

/// One Gauss-Seidel sweep; returns the largest relative step.
double sweep(const std::vector<Wide>& descending, std::vector<WideComplex>& z) {
  double largest = 0;
  for (std::size_t i = 0; i < z.size(); ++i) {
    const Evaluation e = evaluate(descending, z[i]);
    if (magnitude(e.value) <= 1e-31 * e.scale || magnitude(e.slope) == 0) continue;
    WideComplex others;
    for (std::size_t j = 0; j < z.size(); ++j) {
      const WideComplex gap = z[i] - z[j];
      if (j != i && magnitude(gap) > 0) others = others + WideComplex(1.0) / gap;
    }
    const WideComplex newton = e.value / e.slope;
    const WideComplex brake = WideComplex(1.0) - newton * others;
    const WideComplex step = magnitude(brake) > 0 ? newton / brake : newton;
    z[i] = z[i] - step;
    largest = std::max(largest, magnitude(step) / std::max(magnitude(z[i]), 1e-300));
  }
  return largest;
}

/// Moves `centre` to the root of the (m-1)-th derivative next to it; true where the m-fold root there is
/// exact to double-double.
bool settles_on_multiple_root(const std::vector<Wide>& descending, std::size_t m, WideComplex& centre) {
  std::vector<WideComplex> taylor;
  for (int iteration = 0; iteration < 6; ++iteration) {
    taylor.assign(descending.begin(), descending.end());
    for (std::size_t j = 0; j <= m;
         ++j) {  // synthetic division; the j-th Taylor coefficient ends at size - 1 - j
      for (std::size_t k = 1; k + j < taylor.size(); ++k) taylor[k] = taylor[k] + centre * taylor[k - 1];
    }
    const WideComplex lead = taylor[taylor.size() - 1 - m];
    if (magnitude(lead) == 0) return false;
    centre = centre - taylor[taylor.size() - m] / (lead * WideComplex(static_cast<double>(m)));
  }
  double allowed = 1e-25 * evaluate(descending, centre).scale;
  for (std::size_t j = 0; j < m; ++j) {
    if (magnitude(taylor[taylor.size() - 1 - j]) > allowed) return false;
    allowed *= static_cast<double>(descending.size()) / magnitude(centre);
  }
  return true;
}

/// Gives exactly multiple roots one value. Iteration leaves them on a ring of radius 1e-31^(1/m), which no
/// later step could undo.
void merge_multiple_roots(const std::vector<Wide>& descending, std::vector<WideComplex>& z) {
  std::vector<bool> done(z.size());
  for (std::size_t i = 0; i < z.size(); ++i) {
    std::vector<std::size_t> near;
    for (std::size_t j = 0; j < z.size(); ++j) {
      if (!done[j] && !done[i]) near.push_back(j);
    }
    std::sort(near.begin(), near.end(),
              [&](std::size_t a, std::size_t b) { return magnitude(z[a] - z[i]) < magnitude(z[b] - z[i]); });
    for (std::size_t m = near.size(); m >= 2; --m) {
      const double ring = 10 * std::pow(1e-31, 1.0 / static_cast<double>(m)) * magnitude(z[i]);
      if (magnitude(z[near[m - 1]] - z[i]) > std::min(ring, 0.3 * magnitude(z[i]))) continue;
      WideComplex centre;
      for (std::size_t j = 0; j < m; ++j) centre = centre + z[near[j]] / WideComplex(static_cast<double>(m));
      if (std::abs(centre.im.hi) < ring) centre.im = 0;
      if (!settles_on_multiple_root(descending, m, centre)) continue;
      for (std::size_t j = 0; j < m; ++j) {
        z[near[j]] = centre;
        done[near[j]] = true;
      }
      break;
    }
  }
}

/// Makes conjugates exact: a root whose nearest neighbour to its mirror image is itself is real.
std::vector<WideComplex> paired(std::vector<WideComplex> z) {
  std::vector<WideComplex> result;
  while (!z.empty()) {
    const auto top = std::max_element(
        z.begin(), z.end(), [](const WideComplex& a, const WideComplex& b) { return abs(a.im) < abs(b.im); });
    const WideComplex root = *top;
    auto partner = top;
    double nearest = std::numeric_limits<double>::infinity();
    for (auto it = z.begin(); it != z.end(); ++it) {
      const double distance = magnitude(*it - conj(root));
      if (distance < nearest) {
        nearest = distance;
        partner = it;
      }
    }
    if (partner == top) {
      result.emplace_back(root.re);
      z.erase(top);
      continue;
    }
    const WideComplex mean{(root.re + partner->re) * Wide(0.5), abs(root.im - partner->im) * Wide(0.5)};
    result.push_back(mean);
    result.push_back(conj(mean));
    z.erase(std::max(top, partner));
    z.erase(std::min(top, partner));
  }
  return result;
}

}  // namespace

Wide sum(const std::vector<Wide>& coefficients) {
  Wide total;
  for (const Wide& c : coefficients) total += c;
  return total;
}

Deflated divide_out_dc_zeros(const std::vector<double>& ascending) {
  Deflated result;
  result.rest.assign(ascending.begin(), ascending.end());
  // What half a unit in the last place of every coefficient can do to the sum; each division by (1 - q) sums
  // it up.
  std::vector<double> doubt;
  for (const double c : ascending)
    doubt.push_back(0.5 * std::numeric_limits<double>::epsilon() * std::abs(c));
  while (result.rest.size() > 1) {
    double total_doubt = 0;
    for (const double d : doubt) total_doubt += d;
    if (std::abs(sum(result.rest).hi) > total_doubt) break;
    for (std::size_t k = 1; k < result.rest.size(); ++k) {
      result.rest[k] += result.rest[k - 1];
      doubt[k] += doubt[k - 1];
    }
    result.rest.pop_back();
    doubt.pop_back();
    ++result.zeros;
  }
  return result;
}

std::vector<WideComplex> roots(const std::vector<Wide>& descending) {
  if (descending.size() < 2) return {};
  std::vector<WideComplex> z = first_guess(descending);
  for (int i = 0; i < max_sweeps; ++i) {
    if (sweep(descending, z) < 1e-30) break;
  }
  merge_multiple_roots(descending, z);
  return paired(std::move(z));
}

}  // namespace qerr
