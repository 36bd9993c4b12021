#include "simulate/run.hpp"

#include <cmath>
#include <optional>

#include "core/random.hpp"
#include "filter/run/cascade.hpp"
#include "simulate/motion_path.hpp"

namespace qerr {

void BoundsAlongPath::include(const BoundsAlongPath& other) {
  rigorous = rigorous.cwiseMax(other.rigorous);
  deviation = deviation.cwiseMax(other.deviation);
}

std::vector<std::vector<SignalTheory>> theory_along_path(const OperationalError& middle,
                                                         const std::vector<Norms>& norms,
                                                         const Eigen::VectorXd& squares,
                                                         const BoundsAlongPath& bounds) {
  std::vector<std::vector<SignalTheory>> all;
  for (std::size_t f = 0; f <= norms.size(); ++f) {
    Norms n;
    n.h2 = n.dc_gain = n.l1.lower = n.l1.upper = 1;
    if (f > 0) n = norms[f - 1];
    auto& row = all.emplace_back();
    for (Eigen::Index c = 0; c < middle.sigma.size(); ++c) {
      const Bounds b = derivative_error(middle.half_width[c], middle.mean[c], middle.sigma[c], n);
      row.push_back({n.h2 * middle.weighted.row(c).norm() / std::sqrt(12.0),
                     n.h2 * std::sqrt(squares[c] / 12), b.worst_case,
                     f == 0 ? bounds.rigorous[c]
                            : n.l1.upper * bounds.deviation[c] + std::abs(n.dc_gain * middle.mean[c])});
    }
  }
  return all;
}

Eigen::VectorXd center(const Motion& motion) {
  const MotionPath path(motion);
  Eigen::VectorXd middle(path.joints());
  Eigen::MatrixX2d range;
  for (std::size_t i = 0; i < path.joints(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    if (!motion.joints.empty() && motion.joints[i].moves.empty()) {
      middle[row] = motion.joints[i].center + 0.5 * motion.joints[i].velocity * motion.duration;
      continue;
    }
    if (range.rows() == 0) range = extent(motion);
    middle[row] = range.row(row).mean();
  }
  return middle;
}

Eigen::VectorXd displacement_of_run(const Transmission& t, const SimulationOptions& options,
                                    std::uint64_t run) {
  constexpr std::uint64_t stream = 0x7068617365;
  Eigen::VectorXd d = Eigen::VectorXd::Zero(resolutions(t).size());
  if (!options.random_phase) return d;
  const auto first = run * static_cast<std::uint64_t>(d.size());
  for (Eigen::Index i = 0; i < d.size(); ++i)
    d[i] = t.encoders[i].resolution *
           (unit_interval(random_bits(options.seed, first + static_cast<std::uint64_t>(i), stream)) - 0.5);
  return d;
}

namespace {

Eigen::VectorXd displacement(const Job& job, std::uint64_t run) {
  if (!job.every_zero) return displacement_of_run(job.model.transmission, job.options, run);
  return resolutions(job.model.transmission) *
         ((static_cast<double>(run) + 0.5) / static_cast<double>(job.options.runs) - 0.5);
}

/// Samples from .. to - 1 of a batch that belong to block `number` of a record.
struct Part {
  std::size_t from, to, number;
};

/// Assigns samples first .. first + count - 1 to the blocks, equal parts of the record after the settling.
void find_blocks(const Job& job, std::uint64_t first, std::size_t count, std::vector<Part>& all) {
  const auto number = [&](std::size_t i) {
    const double progress = (static_cast<double>(first + i) - static_cast<double>(job.settling)) /
                            static_cast<double>(job.samples - job.settling);
    return static_cast<std::size_t>(progress * static_cast<double>(job.blocks));
  };
  all.clear();
  std::size_t from = job.settling > first ? std::min<std::size_t>(job.settling - first, count) : 0;
  while (from < count) {
    const std::size_t current = number(from);
    std::size_t to = count;
    if (number(count - 1) != current)
      for (to = from + 1; number(to) == current;) ++to;
    all.push_back({from, to, current});
    from = to;
  }
}

/// Keeps the errors of a run in its first samples behind the settling.
class ErrorTracer {
 public:
  /// @param width  of a row of channels, of which the first ones are the exact errors of the coordinates
  ErrorTracer(const Job&, Eigen::Index coordinates, std::size_t width);

  /// @param rows  channels of samples first .. first + count - 1, at most batch_size
  /// @pre called for all samples, in order
  void add(const double* rows, std::uint64_t first, std::size_t count);

  std::vector<ErrorTrace> traces() && { return std::move(traces_); }
  const std::vector<ErrorTrace>& traces() const& { return traces_; }

 private:
  struct Filtered {
    RowFilter filter;
    std::uint64_t every;
  };
  void keep(std::size_t output, const double* row);

  std::size_t width_;
  std::uint64_t settling_,
      end_;  // samples of the motion: the first one that is kept, and the one after the last
  std::vector<Filtered> filters_;
  AlignedNumbers filtered_;
  std::vector<ErrorTrace> traces_;
};

ErrorTracer::ErrorTracer(const Job& job, Eigen::Index coordinates, std::size_t width)
    : width_(width),
      settling_(job.settling),
      end_(std::min(job.samples, job.settling + job.options.traced)),
      filtered_(width * batch_size) {
  const auto add_trace = [&](std::uint64_t every) {
    const double rate = job.motion.sample_rate;
    const std::uint64_t first = (settling_ + every - 1) / every * every;
    traces_.push_back({static_cast<double>(first) / rate, rate / static_cast<double>(every),
                       std::vector<std::vector<double>>(coordinates)});
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

class Runs {
 public:
  Runs(const Job& job, std::uint64_t first, std::size_t count)
      : job_(job),
        channels_(job.model),
        path_(job.motion, job.options.instructions),
        errors_(job.model, as_built(job.model.chain, job.effects), job.mean, job.options.instructions),
        filtered_(rows_at_once * errors_.width()) {
    if (first == 0 && job.options.traced > 0) tracer_.emplace(job, channels_.coordinates, errors_.width());
    const SimulationKernels& kernels = select_kernels<SimulationKernels>(job.options.instructions);
    for (std::uint64_t index = first; index < first + count; ++index) {
      const bool visited = index == 0 && job.options.visit;
      Run& run = runs_.emplace_back(
          Run{Sensing(job.model, job.motion, job.effects,
                      {displacement(job, index), random_bits(job.options.seed, index, 0), visited},
                      job.options.instructions),
              visited,
              {},
              {}});
      for (const Filter& filter : job.filters)
        run.filters.emplace_back(filter, errors_.width(), rows_at_once, job.options.instructions);
      for (std::size_t f = 0; f <= job.filters.size(); ++f)
        run.outputs.emplace_back(channels_.count(), channels_.coordinates, errors_.width(), job.blocks,
                                 kernels);
    }
  }

  RunsResult operator()(const std::function<void()>& tick) {
    for (std::uint64_t first = 0; first < job_.samples; first += batch_size) {
      path_.at(first, std::min<std::uint64_t>(batch_size, job_.samples - first));
      if (runs_.size() > 1) errors_.share(path_);
      find_blocks(job_, first, path_.count(), blocks_);
      for (Run& run : runs_) {
        step(run);
        if (first % tick_samples == 0) tick();
      }
    }
    RunsResult result{{}, {errors_.rigorous(), errors_.deviation()}, {}};
    if (tracer_) result.traces = std::move(*tracer_).traces();
    for (Run& run : runs_) {
      for (RunStatistics& output : run.outputs) output.finish();
      result.outputs.push_back(std::move(run.outputs));
    }
    return result;
  }

 private:
  /// Rows per call of a filter: they stay in the first-level cache from section to section.
  static constexpr std::size_t rows_at_once = 16;

  struct Run {
    Sensing sensing;
    bool visited;
    std::vector<RowFilter> filters;
    std::vector<RunStatistics> outputs;
  };

  /// Simulates one run over the batch.
  void step(Run& run) {
    const std::uint64_t first = path_.first();
    const SensedBatch& sensed = run.sensing.sense(path_);
    for (std::size_t i = 0; run.visited && i < path_.count(); ++i) job_.options.visit(run.sensing.reading(i));
    const bool traced = tracer_ && &run == &runs_.front();
    errors_(sensed);
    // The first error is assumed before the start, so that a constant error causes no transient.
    if (first == 0)
      for (RowFilter& filter : run.filters) filter.settle(errors_.rows());
    if (traced) tracer_->add(errors_.rows(), first, path_.count());
    const std::size_t settling = blocks_.empty() ? path_.count() : blocks_[0].from;
    filter(run, 0, settling, {});
    for (const Part& block : blocks_) {
      run.outputs[0].add(errors_.rows() + block.from * errors_.width(), errors_.width(),
                         block.to - block.from, block.number);
      expect(run, block);
      filter(run, block.from, block.to, block.number);
    }
  }

  /// Filters samples from .. to - 1 of the batch and adds the outputs to a block; during the settling there
  /// is no block.
  void filter(Run& run, std::size_t from, std::size_t to, std::optional<std::size_t> block) {
    const std::size_t width = errors_.width();
    for (std::size_t f = 0; f < run.filters.size(); ++f) {
      const std::uint64_t every = job_.every[f], start = from + until_next(from, every);
      if (start >= to) continue;
      const auto rows = static_cast<std::size_t>((to - start - 1) / every + 1);
      const double* const in = errors_.rows() + start * width;
      for (std::size_t done = 0; done < rows; done += rows_at_once) {
        const std::size_t count = std::min(rows_at_once, rows - done);
        run.filters[f](in + done * every * width, every * width, count, filtered_.data());
        if (block) run.outputs[f + 1].add(filtered_.data(), width, count, *block);
      }
    }
  }

  /// Samples from sample i of the batch to the next one that a filter uses.
  std::uint64_t until_next(std::size_t i, std::uint64_t every) const {
    const std::uint64_t passed = (path_.first() + i) % every;
    return passed == 0 ? 0 : every - passed;
  }

  /// Adds the variance expected from the Jacobian at the samples of a block to the statistics of all outputs.
  void expect(Run& run, const Part& block) const {
    for (Eigen::Index c = 0; c < channels_.coordinates; ++c) {
      const double all = errors_.variance(c, block.from, block.to);
      run.outputs[0].expect(c, all, block.number);
      for (std::size_t f = 0; f < run.filters.size(); ++f) {
        const std::uint64_t every = job_.every[f];
        double selected = every == 1 ? all : 0;
        for (std::uint64_t i = block.from + until_next(block.from, every); every > 1 && i < block.to;
             i += every)
          selected += errors_.variance(c, i, i + 1);
        run.outputs[f + 1].expect(c, selected, block.number);
      }
    }
  }

  const Job& job_;
  Channels channels_;
  PathBatch path_;
  PathErrors errors_;
  AlignedNumbers filtered_;            // rows of a filter's output
  std::optional<ErrorTracer> tracer_;  // of the first run
  std::vector<Part> blocks_;           // of the batch
  std::vector<Run> runs_;
};

}  // namespace

RunsResult run_together(const Job& job, std::uint64_t first, std::size_t count,
                        const std::function<void()>& tick) {
  return Runs(job, first, count)(tick);
}

}  // namespace qerr
