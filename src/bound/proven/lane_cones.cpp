#include "bound/proven/cone_kernels.hpp"
#include "lanes/compiled_set.hpp"

namespace qerr {

namespace {

[[gnu::always_inline]] inline float magnitude(float v) { return v < 0 ? -v : v; }

template <int count>
void raise_cone_row(const ConeSum& sum, float a, float* values) {
  const ConeSum s = sum;
  const int nodes = s.nodes, middle = (nodes - 1) / 2, center = middle * nodes + middle;
  const float cells = static_cast<float>(middle), step = 1 / cells, most = cells - 1;
  const float height_a = 1 - magnitude(a);
#pragma GCC ivdep
  for (int node = 0; node < nodes; ++node) {
    const float b = static_cast<float>(node - middle) * step;
    const float height_b = 1 - magnitude(b);
    const float height = height_a < height_b ? height_a : height_b;
    const float t = s.root * height;
    float total = s.value_a * a + s.value_b * b + s.value_s * height;
    for (int j = 0; j < count; ++j) {
      const float r = s.row_a[j] * a + s.row_b[j] * b + s.row_s[j] * height;
      const float c = s.column_a[j] * a + s.column_b[j] * b + s.column_s[j] * height;
      const float ar = magnitude(r), ac = magnitude(c);
      const float norm = (ar > ac ? ar : ac) + t + 1e-30f;
      const float scale = cells / norm;
      const float pr = ar * scale, pc = ac * scale;
      float ir = static_cast<float>(static_cast<int>(pr)), ic = static_cast<float>(static_cast<int>(pc));
      ir = ir > most ? most : ir;
      ic = ic > most ? most : ic;
      const float fr = pr - ir, fc = pc - ic;
      const int to_r = r < 0 ? -nodes : nodes, to_c = c < 0 ? -1 : 1;
      const int at = center + static_cast<int>(ir) * to_r + static_cast<int>(ic) * to_c;
      const int side = at + (fr < fc ? to_c : to_r);
      const float high = fr < fc ? fc : fr, low = fr < fc ? fr : fc;
      const float* table = s.table[j];
      const float value = table[at] * (1 - high) + table[side] * (high - low) + table[at + to_r + to_c] * low;
      total += s.weight[j] * norm * value;
    }
    values[node] = values[node] < total ? total : values[node];
  }
}

void raise_cone(const ConeSum& sum, int first, int last, float* values) {
  const int middle = (sum.nodes - 1) / 2;
  for (int node = first; node < last; ++node) {
    const float a = static_cast<float>(node - middle) * (1 / static_cast<float>(middle));
    float* row = values + node * sum.nodes;
    if (sum.count == 0)
      raise_cone_row<0>(sum, a, row);
    else if (sum.count == 1)
      raise_cone_row<1>(sum, a, row);
    else if (sum.count == 2)
      raise_cone_row<2>(sum, a, row);
    else
      raise_cone_row<3>(sum, a, row);
  }
}

}  // namespace

template <>
const ConeKernels& compiled_kernels<ConeKernels, lanes::compiled_set>() {
  static constexpr ConeKernels kernels{raise_cone};
  return kernels;
}

}  // namespace qerr
