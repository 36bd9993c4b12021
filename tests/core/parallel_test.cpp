#include "core/parallel.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

namespace qerr {
namespace {

TEST(Parallel, RunsEveryTaskOnceAndRethrows) {
  for (const unsigned threads : {1u, 2u, 7u}) {
    std::vector<int> done(1000);
    parallel_for(done.size(), threads, [&](std::size_t i) { ++done[i]; });
    EXPECT_EQ(done, std::vector<int>(1000, 1));
  }
  EXPECT_THROW(parallel_for(100, 3,
                            [](std::size_t i) {
                              if (i == 57) throw std::runtime_error("57");
                            }),
               std::runtime_error);
}

}  // namespace
}  // namespace qerr
