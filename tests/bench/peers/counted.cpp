#include "counted.hpp"

#include "bound/lane_errors.hpp"

namespace qerr::lanes {
namespace {

double multiplied = 0;

/// A number that counts its multiplications: each is one operation of the FMA pipes, fused or not. Additions
/// have separate adders, or are fused with a multiplication.
struct Counted {
  double value;
};

Counted product(double a, double b) {
  ++multiplied;
  return {a * b};
}

Counted operator*(Counted a, Counted b) { return product(a.value, b.value); }
Counted operator*(double a, Counted b) { return product(a, b.value); }
Counted operator/(double a, Counted b) { return {a / b.value}; }
Counted operator+(Counted a, Counted b) { return {a.value + b.value}; }
Counted operator+(Counted a, double b) { return {a.value + b}; }
Counted operator+(double a, Counted b) { return {a + b.value}; }
Counted operator-(Counted a, Counted b) { return {a.value - b.value}; }
Counted operator-(Counted a, double b) { return {a.value - b}; }
Counted operator-(double a, Counted b) { return {a - b.value}; }
Counted operator-(Counted a) { return {-a.value}; }
Counted& operator+=(Counted& a, Counted b) { return a = a + b; }
bool operator<(Counted a, Counted b) { return a.value < b.value; }
bool operator>(Counted a, Counted b) { return a.value > b.value; }
bool operator<(Counted a, double b) { return a.value < b; }
Counted abs(const Counted& a) { return {a.value < 0 ? -a.value : a.value}; }
Counted sqrt(const Counted& a) { return {__builtin_sqrt(a.value)}; }

/// Logical operations, without multiplications.
SineCosine<Counted> add_quarter_turns(const SineCosine<Counted>& a, const Counted& n) {
  const auto quarter = __builtin_bit_cast(std::uint64_t, n.value) & 3;
  const Counted sine = quarter & 1 ? a.cosine : a.sine, cosine = quarter & 1 ? a.sine : a.cosine;
  return {quarter & 2 ? -sine : sine, (quarter + 1) & 2 ? -cosine : cosine};
}

}  // namespace
}  // namespace qerr::lanes

namespace qerr::bench {

using lanes::Counted;
using lanes::multiplied;

double multiplications(const FoldedPath& chain, const double* scale, const double* q, double* room) {
  auto* const moved = reinterpret_cast<lanes::SineCosine<Counted>*>(room);
  multiplied = 0;
  auto* const joints = reinterpret_cast<lanes::JointScratch<Counted>*>(moved + chain.count);
  lanes::prepare_first_joint(chain, scale, joints);
  lanes::StoreColumns<Counted> keep{joints};
  lanes::columns<Counted>(chain, scale, q, batch_size, moved, joints, lanes::Ignore{}, keep);
  return multiplied;
}

double multiplications(const ErrorPlan& plan, const double* q, double* figures, double* sums, double* room) {
  multiplied = 0;
  lanes::errors<Counted>(plan, q, figures, sums, room);
  return multiplied / batch_size;
}

}  // namespace qerr::bench
