#include "bound/kernels.hpp"
#include "bound/lane_errors.hpp"
#include "lanes/batch.hpp"
#include "lanes/lanes.hpp"
#include "lanes/select_kernels.hpp"

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

#if defined(__AVX2__)
#include <immintrin.h>
#endif

namespace qerr::lanes {
namespace {

/// Maximum of a batch.
template <class L>
[[gnu::always_inline]] inline double largest(const double* values) {
  L high = load<L>(values);
  for (std::size_t i = lane_count<L>; i < batch_size; i += lane_count<L>)
    high = max(load<L>(values + i), high);
  double most = high[0];
#pragma GCC unroll 8
  for (std::size_t i = 1; i < lane_count<L>; ++i) most = high[i] > most ? high[i] : most;
  return most;
}

/// Updates the maxima of a batch in which at least one is new, and their configurations.
template <class L>
[[gnu::noinline]] void find_maxima(const double* figures, std::size_t count, std::uint64_t first,
                                   Tally* tallies) {
  for (std::size_t f = 0; f < count; ++f) {
    const double* const values = figures + f * batch_size;
    Tally& t = tallies[f];
    const double most = largest<L>(values);
    if (!(most > t.max)) continue;
    const bool is_larger = most > same_maximum * t.max;
    t.max = most;
    for (std::size_t i = 0; i < batch_size && is_larger; ++i)
      if (values[i] * same_maximum >= most) {
        t.at_max = first + i;
        break;
      }
  }
}

/// A vector of bins, twice as many as doubles.
template <class L>
struct BinsOf {
  typedef std::int32_t type __attribute__((vector_size(sizeof(L))));
  static constexpr std::size_t count = 2 * lane_count<L>;
};
template <class L>
using Bins = typename BinsOf<L>::type;

/// Bins of two vectors of values, from the upper halves of the doubles.
template <class L>
[[gnu::always_inline]] inline Bins<L> bins_of(const double* values) {
  constexpr int u = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ ? 1 : 0;
  const auto a = __builtin_bit_cast(Bins<L>, load<L>(values)),
             b = __builtin_bit_cast(Bins<L>, load<L>(values + lane_count<L>));
  Bins<L> upper;
  if constexpr (lane_count<L> == 8)
    upper = __builtin_shufflevector(a, b, u, u + 2, u + 4, u + 6, u + 8, u + 10, u + 12, u + 14, u + 16,
                                    u + 18, u + 20, u + 22, u + 24, u + 26, u + 28, u + 30);
  else if constexpr (lane_count<L> == 4)
    upper = __builtin_shufflevector(a, b, u, u + 2, u + 4, u + 6, u + 8, u + 10, u + 12, u + 14);
  else
    upper = __builtin_shufflevector(a, b, u, u + 2, u + 4, u + 6);
  return upper >> (bin_shift - 32);
}

#if defined(__AVX2__)
/// [mask]: indices of the set bits of an 8-bit mask, a byte each.
constexpr struct KeptIndices {
  std::uint64_t of[256] = {};

  constexpr KeptIndices() {
    for (unsigned mask = 0; mask < 256; ++mask) {
      int shift = 0;
      for (std::uint64_t bit = 0; bit < 8; ++bit)
        if (mask >> bit & 1) of[mask] |= bit << shift, shift += 8;
    }
  }
} kept_indices;
#endif

/// Appends the bins whose `kept` is negative.
/// @param to  end of the list; a whole vector is written
/// @returns the new end
template <class L>
[[gnu::always_inline]] inline std::int32_t* append(const Bins<L>& bins, const Bins<L>& kept,
                                                   std::int32_t* to) {
#if defined(__AVX512F__) && defined(__AVX512DQ__)
  if constexpr (lane_count<L> == 8) {
    const auto mask = _mm512_movepi32_mask(__builtin_bit_cast(__m512i, kept));
    const auto packed = _mm512_maskz_compress_epi32(mask, __builtin_bit_cast(__m512i, bins));
    __builtin_memcpy(to, &packed, sizeof packed);
    return to + __builtin_popcount(mask);
  }
#endif
#if defined(__AVX2__)
  if constexpr (lane_count<L> == 4) {
    const auto mask = static_cast<unsigned>(_mm256_movemask_ps(__builtin_bit_cast(__m256, kept)));
    const auto indices = _mm_cvtsi64_si128(static_cast<long long>(kept_indices.of[mask]));
    const auto packed =
        _mm256_permutevar8x32_epi32(__builtin_bit_cast(__m256i, bins), _mm256_cvtepu8_epi32(indices));
    __builtin_memcpy(to, &packed, sizeof packed);
    return to + __builtin_popcount(mask);
  }
#endif
#pragma GCC unroll 16
  for (std::size_t i = 0; i < BinsOf<L>::count; ++i) {
    *to = bins[i];
    to += kept[i] < 0;
  }
  return to;
}

/// A Tally in registers; adds eight values at a time.
template <class L>
class FigureTally {
 public:
  [[gnu::always_inline]] explicit FigureTally(const Tally& tally) {
#pragma GCC unroll 8
    for (std::size_t p = 0; p < packs; ++p) {
      low_[p] = load<L>(tally.min + p * lane_count<L>);
      sum_[p] = load<L>(tally.sum + p * lane_count<L>);
      high_[p] = broadcast<L>(tally.max);
    }
  }

  [[gnu::always_inline]] void add(const double* values) {
#pragma GCC unroll 8
    for (std::size_t p = 0; p < packs; ++p) {
      const L value = load<L>(values + p * lane_count<L>);
      low_[p] = min(low_[p], value);
      high_[p] = max(high_[p], value);
      sum_[p] += value;
    }
  }

  /// @param increased  set in the lanes in which the maximum is larger than before
  [[gnu::always_inline]] void finish(Tally& tally, Bits<L>& increased) const {
#pragma GCC unroll 8
    for (std::size_t p = 0; p < packs; ++p) {
      store(tally.sum + p * lane_count<L>, sum_[p]);
      store(tally.min + p * lane_count<L>, low_[p]);
      increased |= high_[p] > broadcast<L>(tally.max);
    }
  }

 private:
  static constexpr std::size_t packs = 8 / lane_count<L>;

  L low_[packs], high_[packs], sum_[packs];
};

/// A BinList in registers; adds `at_once` values at a time.
template <class L>
class FigureBins {
 public:
  static constexpr std::size_t at_once = BinsOf<L>::count;

  [[gnu::always_inline]] explicit FigureBins(const BinList& list) : counted_(list.counted), next_(list.next) {
    static_assert(sizeof below_ <= sizeof list.below);
    __builtin_memcpy(&below_, list.below, sizeof below_);
  }

  [[gnu::always_inline]] void add(const double* values) {
    const Bins<L> bins = bins_of<L>(values), from_begin = bins - counted_.begin;  // negative: below
    below_ -= from_begin >> 31;
    next_ = append<L>(bins, (~from_begin & (bins - counted_.end)) | (counted_.top - 1 - bins), next_);
  }

  [[gnu::always_inline]] void finish(BinList& list) const {
    __builtin_memcpy(list.below, &below_, sizeof below_);
    list.next = next_;
  }

 private:
  const CountedBins counted_;
  std::int32_t* next_;
  Bins<L> below_;
};

template <class L>
void tally(std::size_t count, const double* figures, std::uint64_t first, Tally* tallies, BinList* lists) {
  Bits<L> increased{};
  for (std::size_t f = 0; f < count; ++f) {
    const double* const values = figures + f * batch_size;
    FigureTally<L> figure(tallies[f]);
    if (lists) {
      FigureBins<L> bins(lists[f]);
      for (std::size_t i = 0; i < batch_size; i += 16) {
        figure.add(values + i);
        figure.add(values + i + 8);
        for (std::size_t j = 0; j < 16; j += bins.at_once) bins.add(values + i + j);
      }
      bins.finish(lists[f]);
    } else {
      for (std::size_t i = 0; i < batch_size; i += 8) figure.add(values + i);
    }
    figure.finish(tallies[f], increased);
  }
  std::int64_t any = 0;
#pragma GCC unroll 8
  for (std::size_t i = 0; i < lane_count<L>; ++i) any |= increased[i];
  if (any) find_maxima<L>(figures, count, first, tallies);  // rare
}

}  // namespace

namespace {

/// Values of `count` forms of one shape. They share what is loaded of the columns, and some eight sums
/// overlap in the pipeline: a quarter of the time of one form and one vector.
template <std::size_t count, bool squared, bool biased, bool rooted, class L>
void forms_of(const double* const* columns, const ColumnForm* form, double* figures) {
  constexpr std::size_t vectors = count > 1 ? 2 : 4;
  for (std::size_t i = 0; i < batch_size; i += vectors * lane_count<L>) {
    L sum[count][vectors] = {}, mean[count][vectors] = {};
    for (std::size_t k = 0; k < form->columns; ++k) {
      L column[vectors], size[vectors];
#pragma GCC unroll 4
      for (std::size_t v = 0; v < vectors; ++v) {
        column[v] = load<L>(columns[k] + i + v * lane_count<L>);
        size[v] = squared ? column[v] * column[v] : abs(column[v]);
      }
#pragma GCC unroll 4
      for (std::size_t f = 0; f < count; ++f) {
        const L weight = broadcast<L>(form[f].weights[k]);
        const L of_mean = broadcast<L>(biased ? form[f].means[k] : 0);
#pragma GCC unroll 4
        for (std::size_t v = 0; v < vectors; ++v) {
          sum[f][v] = fma(size[v], weight, sum[f][v]);
          if (biased) mean[f][v] = fma(column[v], of_mean, mean[f][v]);
        }
      }
    }
#pragma GCC unroll 4
    for (std::size_t f = 0; f < count; ++f)
#pragma GCC unroll 4
      for (std::size_t v = 0; v < vectors; ++v) {
        const L all = sum[f][v] + form[f].added;
        store(figures + f * batch_size + i + v * lane_count<L>,
              rooted    ? sqrt(all)
              : squared ? all
                        : min(biased ? all + abs(mean[f][v]) : all, broadcast<L>(form[f].most)));
      }
  }
}

template <std::size_t count, class L>
void forms_of(const double* const* columns, const ColumnForm* form, bool rooted, double* figures) {
  (form->squared ? rooted ? forms_of<count, true, false, true, L> : forms_of<count, true, false, false, L>
   : form->means ? forms_of<count, false, true, false, L>
                 : forms_of<count, false, false, false, L>)(columns, form, figures);
}

/// Whether both are computed by the same instructions.
bool have_one_shape(const ColumnForm& a, const ColumnForm& b) {
  return a.squared == b.squared && a.columns == b.columns && !a.means == !b.means;
}

template <class L>
void forms(const double* const* columns, std::size_t count, const ColumnForm* form, bool rooted,
           double* figures) {
  constexpr std::size_t together = 4;
  while (count > 0) {
    std::size_t done = 1;
    while (done < count && done < together && have_one_shape(form[0], form[done])) ++done;
    if (done < together) done = 1;
    (done == together ? forms_of<together, L> : forms_of<1, L>)(columns, form, rooted, figures);
    count -= done, form += done, figures += done * batch_size;
  }
}

template <class L>
double* append_larger(const double* values, double least, double* to) {
  constexpr std::size_t at_once = 16;  // few of which have one, where a hundredth of all values are larger
  for (const double* const end = values + batch_size; values != end; values += at_once) {
    Bits<L> larger{};
#pragma GCC unroll 8
    for (std::size_t i = 0; i < at_once; i += lane_count<L>) larger |= load<L>(values + i) > least;
    std::int64_t any = 0;
#pragma GCC unroll 8
    for (std::size_t i = 0; i < lane_count<L>; ++i) any |= larger[i];
    if (!any) continue;
    for (std::size_t i = 0; i < at_once; ++i) {  // without branches, which would be mispredicted
      *to = values[i];
      to += values[i] > least;
    }
  }
  return to;
}

}  // namespace
}  // namespace qerr::lanes

namespace qerr {

template <>
const BoundKernels& compiled_kernels<BoundKernels, lanes::compiled_set>() {
  using namespace lanes;
  using L = CompiledLanes;
  static constexpr BoundKernels kernels{lane_count<L>, scratch<L>,       errors<L>,         tally<L>,
                                        forms<L>,      append_larger<L>, largest_corners<L>};
  return kernels;
}

}  // namespace qerr
