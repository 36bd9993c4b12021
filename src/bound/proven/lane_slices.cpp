#include "bound/proven/slice_kernels.hpp"
#include "lanes/compiled_set.hpp"

namespace qerr {

namespace {

template <int count>
void raise_row(const SliceSum& sum, float a, int begin, int end, float* values) {
  const SliceSum s = sum;
  float row[3], column[3];
  for (int j = 0; j < count; ++j) {
    row[j] = s.row_0[j] + a * s.row_a[j];
    column[j] = s.column_0[j] + a * s.column_a[j];
  }
  const float value = s.value_0 + a * s.value_a;
  const int nodes = s.table_nodes;
  const float most = static_cast<float>(nodes - 2);
#pragma GCC ivdep
  for (int b = begin; b < end; ++b) {
    const float at = static_cast<float>(b);
    float total = value + at * s.value_b;
    for (int j = 0; j < count; ++j) {
      float r = row[j] + at * s.row_b[j], c = column[j] + at * s.column_b[j];
      r = r < 0 ? 0 : r;
      c = c < 0 ? 0 : c;
      float ri = static_cast<float>(static_cast<int>(r)), ci = static_cast<float>(static_cast<int>(c));
      ri = ri > most ? most : ri;
      ci = ci > most ? most : ci;
      const float fr = r - ri, fc = c - ci;
      const int i = static_cast<int>(ri) * nodes + static_cast<int>(ci);
      const float* t = s.table[j];
      const float lower = t[i] + fc * (t[i + 1] - t[i]);
      const float upper = t[i + nodes] + fc * (t[i + nodes + 1] - t[i + nodes]);
      total += s.weight[j] * (lower + fr * (upper - lower));
    }
    values[b] = values[b] < total ? total : values[b];
  }
}

void raise(const SliceSum& sum, const SliceNodes& nodes, float* values) {
  for (int a = 0; a < nodes.nodes; ++a) {
    float* row = values + a * nodes.nodes;
    const float at = static_cast<float>(a);
    if (sum.count == 0)
      raise_row<0>(sum, at, nodes.begin[a], nodes.end[a], row);
    else if (sum.count == 2)
      raise_row<2>(sum, at, nodes.begin[a], nodes.end[a], row);
    else
      raise_row<3>(sum, at, nodes.begin[a], nodes.end[a], row);
  }
}

}  // namespace

template <>
const SliceKernels& compiled_kernels<SliceKernels, lanes::compiled_set>() {
  static constexpr SliceKernels kernels{raise};
  return kernels;
}

}  // namespace qerr
