#include "qerr/design/requirement.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace qerr {
namespace {

TEST(Requirement, IsMetByAValueThatEqualsTheLimitAndByNoneBeyond) {
  Workspace w;
  w.coordinates.resize(1);
  ProvenMaximum proven;
  for (const bool at_least : {false, true})
    for (const double limit : {0.3, 1e-9, 0.0, 7e5}) {
      Requirement r;
      r.bound = Bound::sigma;
      r.at_least = at_least;
      r.limit = limit;
      const double beyond = std::nextafter(limit, at_least ? -INFINITY : INFINITY);
      for (const double value : {limit, beyond}) {
        w.coordinates[0].sigma.max = proven.lower = proven.upper = value;
        EXPECT_EQ(evaluate(r, w, {}, {}).met, value == limit);
        EXPECT_EQ(evaluate(r, proven).met, value == limit);
        EXPECT_EQ(evaluate(r, value).met, value == limit);
      }
    }
}

}  // namespace
}  // namespace qerr
