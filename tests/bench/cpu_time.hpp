#pragma once

#include <benchmark/benchmark.h>
#include <time.h>

namespace qerr::bench {

/// CPU time of a function on this thread [s].
template <class Part>
double cpu_seconds(Part part) {
  const auto now = [] {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  };
  const double start = now();
  benchmark::DoNotOptimize(part());
  return now() - start;
}

}  // namespace qerr::bench
