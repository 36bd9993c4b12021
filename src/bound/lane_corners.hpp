#pragma once

#include "bound/kernels.hpp"
#include "lanes/batch.hpp"
#include "lanes/lanes.hpp"

// One configuration per lane: a sweep of 100 designs with x y z and xyz takes 4.2 s against 12.6 one
// configuration at a time (Panda, 1e5 Sobol points, one AVX2 thread).

namespace qerr::lanes {
namespace {

template <class L>
struct Vector3 {
  L x, y, z;

  [[gnu::always_inline]] Vector3 operator+(const Vector3& b) const { return {x + b.x, y + b.y, z + b.z}; }
  [[gnu::always_inline]] L dot(const Vector3& b) const { return fma(x, b.x, fma(y, b.y, z * b.z)); }
  [[gnu::always_inline]] Vector3 cross(const Vector3& b) const {
    return {y * b.z - z * b.y, z * b.x - x * b.z, x * b.y - y * b.x};
  }
  /// Turned round in the lanes in which `along` is negative.
  [[gnu::always_inline]] Vector3 along(const L& along) const {
    return {along < 0 ? -x : x, along < 0 ? -y : y, along < 0 ? -z : z};
  }
  /// Zero in the other lanes.
  [[gnu::always_inline]] Vector3 in(const Bits<L>& lanes) const {
    return {lanes ? x : L{}, lanes ? y : L{}, lanes ? z : L{}};
  }
};

/// The vectors of a batch that begin at one of its configurations.
template <class L>
struct BatchVectors {
  const double* from;
  [[gnu::always_inline]] Vector3<L> operator[](std::size_t i) const {
    const double* const at = from + 3 * i * batch_size;
    return {load<L>(at), load<L>(at + batch_size), load<L>(at + 2 * batch_size)};
  }
};

/// Squared length of the farther one of mean + corner and mean - corner.
template <class L>
[[gnu::always_inline]] inline L square_from(const Vector3<L>& mean, const Vector3<L>& corner) {
  return corner.dot(corner) + mean.dot(mean) + 2.0 * abs(mean.dot(corner));
}

template <class L>
L largest_of_all(const Vector3<L>& mean, const BatchVectors<L>& g, std::size_t count) {
  Vector3<L> corner{};
  for (std::size_t i = 0; i < count; ++i) corner = corner + g[i];
  L largest = square_from(mean, corner);
  std::uint64_t signs = 0;
  for (std::uint64_t k = 1; k < (std::uint64_t{1} << (count - 1)); ++k) {
    const auto turned = static_cast<std::size_t>(__builtin_ctzll(k));  // Gray code: one sign a step
    signs ^= std::uint64_t{1} << turned;
    const double by = signs >> turned & 1 ? -2 : 2;
    const Vector3<L> v = g[turned];
    corner = {fma(by, v.x, corner.x), fma(by, v.y, corner.y), fma(by, v.z, corner.z)};
    largest = max(largest, square_from(mean, corner));
  }
  return largest;
}

template <class L>
bool any(const Bits<L>& lanes) {
  std::int64_t all = 0;
  for (std::size_t i = 0; i < lane_count<L>; ++i) all |= lanes[i];
  return all != 0;
}

/// Squared length below which a product of two vectors is rounding: sines of angles up to 1e-12.
constexpr double parallel = 1e-24;

/// The largest over the vertices of the face that g_i and g_j span, at the ends of its edges along g_i.
/// @param in_face  [generator]: memory for lanes in which it lies in the face
template <class L>
L largest_of_face(const Vector3<L>& mean, const BatchVectors<L>& g, std::size_t count, std::size_t i,
                  std::size_t j, Bits<L>* in_face) {
  const Vector3<L> a = g[i], b = g[j], normal = a.cross(b), across = normal.cross(a);
  const L square = normal.dot(normal), across_square = across.dot(across);
  Vector3<L> center{};
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3<L> v = g[k];
    const L off = normal.dot(v);
    in_face[k] = off * off <= parallel * square * v.dot(v);
    center = center + v.along(off).in(~in_face[k]);
  }
  L largest{};
  for (const double side : {-1.0, 1.0})
    for (const double end : {-1.0, 1.0}) {
      Vector3<L> corner = center;
      for (std::size_t k = 0; k < count; ++k) {
        if (!any<L>(in_face[k])) continue;
        const Vector3<L> v = g[k];
        const L aside = across.dot(v);
        const Bits<L> at_edge = aside * aside <= parallel * across_square * v.dot(v);
        corner = corner + v.along(at_edge ? end * a.dot(v) : side * aside).in(in_face[k]);
      }
      largest = max(largest, square_from(mean, corner));
    }
  return square > parallel * a.dot(a) * b.dot(b) ? largest : L{};
}

template <class L>
L largest_vertex(const Vector3<L>& mean, const BatchVectors<L>& g, std::size_t count, Bits<L>* in_face) {
  Vector3<L> longest{};  // along which the corner lies if all are parallel
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3<L> v = g[k];
    const Bits<L> longer = v.dot(v) > longest.dot(longest);
    longest = v.in(longer) + longest.in(~longer);
  }
  Vector3<L> corner{};
  for (std::size_t k = 0; k < count; ++k) corner = corner + g[k].along(longest.dot(g[k]));
  L largest = square_from(mean, corner);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = i + 1; j < count; ++j)
      largest = max(largest, largest_of_face(mean, g, count, i, j, in_face));
  return largest;
}

/// As BoundKernels::largest_corners.
template <class L>
void largest_corners(std::size_t generators, const double* mean, const double* g, std::size_t count,
                     double* to, double* scratch) {
  constexpr std::size_t most_tried = 12;
  for (std::size_t c = 0; c < count; c += lane_count<L>) {
    const Vector3<L> m = BatchVectors<L>{mean + c}[0];
    const BatchVectors<L> vectors{g + c};
    const L square = generators == 0 ? m.dot(m)
                     : generators <= most_tried
                         ? largest_of_all(m, vectors, generators)
                         : largest_vertex(m, vectors, generators, reinterpret_cast<Bits<L>*>(scratch));
    store(to + c, sqrt(square));
  }
}

}  // namespace
}  // namespace qerr::lanes
