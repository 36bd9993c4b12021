#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

#include "core/parallel.hpp"
#include "core/random.hpp"

namespace qerr {
namespace {

TEST(TextsInOrder, ArePassedOnOnceInOrderByAnyNumberOfThreads) {
  for (const unsigned threads : {1u, 2u, 5u}) {
    std::vector<std::string> passed;
    std::atomic<std::uint64_t> made = 0, handed = 0;
    texts_in_order(
        200, threads,
        [&](std::uint64_t i) {
          if (random_bits(threads, i, 0) % 8 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
          // Memory is bounded: not more than a few texts for each thread are ahead.
          EXPECT_LE(++made, handed + 8 * threads + 1);
          return std::to_string(i);
        },
        [&](std::uint64_t i, std::string text) {
          EXPECT_EQ(i, passed.size());
          passed.push_back(std::move(text));
          ++handed;
        });
    ASSERT_EQ(passed.size(), 200u);
    for (std::size_t i = 0; i < passed.size(); ++i) EXPECT_EQ(passed[i], std::to_string(i));
  }
}

TEST(TextsInOrder, AFailureComesAfterTheTextsBeforeIt) {
  for (const unsigned threads : {1u, 4u}) {
    std::uint64_t passed = 0;
    const auto run = [&] {
      texts_in_order(
          100, threads,
          [](std::uint64_t i) {
            if (i == 37) throw std::runtime_error("37");
            return std::string();
          },
          [&](std::uint64_t, const std::string&) { ++passed; });
    };
    EXPECT_THROW(run(), std::runtime_error);
    EXPECT_EQ(passed, 37u);
  }
}

TEST(TextsInOrder, AFailureToPassOnEndsTheWork) {
  std::atomic<int> made = 0;
  const auto run = [&] {
    texts_in_order(
        100000, 3, [&](std::uint64_t) { return ++made, std::string(); },
        [](std::uint64_t i, const std::string&) {
          if (i == 3) throw std::runtime_error("disk full");
        });
  };
  EXPECT_THROW(run(), std::runtime_error);
  EXPECT_LT(made, 100);
}

}  // namespace
}  // namespace qerr
