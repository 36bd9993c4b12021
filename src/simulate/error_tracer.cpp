#include "simulate/error_tracer.hpp"

#include <algorithm>

#include "lanes/batch.hpp"

namespace qerr {

ErrorTracer::ErrorTracer(const Job& job, Eigen::Index coordinates, std::size_t width)
    : width_(width),
      settling_(job.settling),
      end_(std::min(job.samples, job.settling + job.options.traced)),
      filtered_(width * batch_size) {
  const auto add_trace = [&](std::uint64_t every) {
    const double rate = job.motion.sample_rate;
    const std::uint64_t first = (settling_ + every - 1) / every * every;
    traces_.push_back({static_cast<double>(first) / rate, rate / static_cast<double>(every),
                       std::vector<std::vector<double>>(static_cast<std::size_t>(coordinates))});
  };
  add_trace(1);
  for (std::size_t f = 0; f < job.filters.size(); ++f) {
    filters_.push_back(
        {RowFilter(job.filters[f], width, batch_size, job.options.instructions), job.every[f]});
    add_trace(job.every[f]);
  }
}

void ErrorTracer::keep(std::size_t output, const double* row) {
  for (std::size_t c = 0; c < traces_[output].error.size(); ++c) traces_[output].error[c].push_back(row[c]);
}

void ErrorTracer::add(const double* rows, std::uint64_t first, std::size_t count) {
  if (first >= end_) return;
  count = static_cast<std::size_t>(std::min<std::uint64_t>(count, end_ - first));
  for (std::size_t i = 0; i < count; ++i)
    if (first + i >= settling_) keep(0, rows + i * width_);
  for (std::size_t f = 0; f < filters_.size(); ++f) {
    auto& [filter, every] = filters_[f];
    // As in the simulation: the first error is assumed before the start.
    if (first == 0) filter.settle(rows);
    const std::uint64_t start = (first + every - 1) / every * every - first;
    if (start >= count) continue;
    const auto used = static_cast<std::size_t>((count - 1 - start) / every + 1);
    filter(rows + start * width_, every * width_, used, filtered_.data());
    for (std::size_t i = 0; i < used; ++i)
      if (first + start + i * every >= settling_) keep(f + 1, filtered_.data() + i * width_);
  }
}

}  // namespace qerr
