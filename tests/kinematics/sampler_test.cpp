#include "kinematics/sampler.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "lanes/batch.hpp"
#include "support/random_chain.hpp"

namespace qerr {
namespace {

using testing::Dice;

// Every batch of every method, on every instruction set, bitwise.
RC_GTEST_PROP(Sampler, EqualsDraw, ()) {
  Configurations c;
  c.method = *rc::gen::element(SamplingMethod::sobol, SamplingMethod::random, SamplingMethod::grid,
                               SamplingMethod::list);
  c.seed = *rc::gen::arbitrary<std::uint64_t>();
  Dice dice(c.seed);
  const auto joints = *rc::gen::inRange<std::size_t>(1, 20);
  for (std::size_t j = 0; j < joints; ++j) {
    const double lower = dice.between(-4, 4);
    c.ranges.push_back({lower, lower + dice.between(0, 3)});
  }
  c.count = c.method == SamplingMethod::grid ? 3 : std::uint64_t{1} << *rc::gen::inRange(6, 62);
  if (c.method == SamplingMethod::list)
    for (int i = 0; i < 300; ++i) c.points.push_back(dice.vector(static_cast<Eigen::Index>(joints), -3, 3));
  const std::uint64_t batches = size(c) / batch_size;
  if (batches == 0) return;
  const std::uint64_t first = batch_size * (*rc::gen::arbitrary<std::uint64_t>() % batches);
  const Eigen::MatrixXd expected = draw(c, first, batch_size);
  AlignedNumbers q(joints * batch_size);
  for (const InstructionSet set : available_instruction_sets()) {
    Sampler(c, set)(first, q.data());
    for (std::size_t j = 0; j < joints; ++j)
      for (std::size_t i = 0; i < batch_size; ++i)
        RC_ASSERT(q[j * batch_size + i] ==
                  expected(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(i)));
  }
}

}  // namespace
}  // namespace qerr
