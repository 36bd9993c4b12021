#include "bound/proven/branch_and_bound.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>

#include "bound/proven/box_bound.hpp"

namespace qerr {

namespace {

struct OpenBox {
  double upper;
  std::size_t index;
  bool operator<(const OpenBox& other) const {  // of equal bounds the older one first
    return upper != other.upper ? upper < other.upper : index > other.index;
  }
};

class BoxSearch {
 public:
  BoxSearch(const ErrorTerms& terms, const std::vector<Limits>& ranges, double enough)
      : bound_(terms, ranges), ranges_(ranges), enough_(std::max(enough, 8 * bound_.rounding())) {}

  SearchedMaximum run(std::size_t boxes) {
    const auto n = static_cast<Eigen::Index>(ranges_.size());
    Eigen::VectorXd center(n), half(n);
    for (Eigen::Index j = 0; j < n; ++j) {
      const Limits& range = ranges_[static_cast<std::size_t>(j)];
      center[j] = 0.5 * (range.lower + range.upper);
      // Half of the range rounded up: center and half width contain both ends.
      half[j] = bound_.matters(static_cast<std::size_t>(j))
                    ? std::max(range.upper - center[j], center[j] - range.lower) * widened
                    : 0;
    }
    add(center, half);
    for (std::size_t done = 1; !open_.empty() && done < boxes; done += 2) {
      const OpenBox box = open_.top();
      if (!(box.upper > enough_)) break;
      open_.pop();
      split(box.index);
    }
    result_.upper = std::max(closed_, open_.empty() ? 0 : open_.top().upper);
    return std::move(result_);
  }

 private:
  static constexpr double widened =
      1 + 0x1p-50;  // for what is lost in rounding the half width and the center
  static double least_half(double center) { return 0x1p-50 * std::abs(center); }

  void add(const Eigen::VectorXd& center, const Eigen::VectorXd& half) {
    const BoxBound::Result bound = bound_(center, half);
    if (bound.at_center > largest_) {
      largest_ = bound.at_center;
      result_.at = center;
    }
    if (!(bound.upper > enough_) || half.isZero(0)) {
      closed_ = std::max(closed_, bound.upper);
      return;
    }
    open_.push({bound.upper, centers_.size()});
    centers_.push_back(center);
    halves_.push_back(half);
    widest_.push_back(static_cast<Eigen::Index>(bound.widest));
  }

  void split(std::size_t box) {
    const Eigen::Index along = widest_[box];
    Eigen::VectorXd center = std::move(centers_[box]), half = std::move(halves_[box]);
    const double middle = center[along], quarter = 0.5 * half[along];
    half[along] = quarter * widened + least_half(middle) + least_half(quarter);
    center[along] = middle - quarter;
    add(center, half);
    center[along] = middle + quarter;
    add(center, half);
  }

  BoxBound bound_;
  const std::vector<Limits>& ranges_;
  double enough_, closed_ = 0, largest_ = -1;
  SearchedMaximum result_;
  std::priority_queue<OpenBox> open_;
  std::vector<Eigen::VectorXd> centers_, halves_;
  std::vector<Eigen::Index> widest_;
};

/// The ranges of the joints, and of the base of `along_any_direction`.
std::vector<Limits> with_base(std::vector<Limits> ranges) {
  ranges.insert(ranges.end(), 2, {-std::numbers::pi / 2, std::numbers::pi / 2});
  return ranges;
}

}  // namespace

SearchedMaximum branch_and_bound(const ErrorTerms& terms, const std::vector<Limits>& ranges,
                                 double known_lower, double gap, std::size_t boxes) {
  const double enough = known_lower * (1 + gap);
  if (!terms.length() || terms.sigma()) return BoxSearch(terms, ranges, enough).run(boxes);
  const std::vector<Limits> all = with_base(ranges);
  const ErrorTerms along_x = terms.along_any_direction(ranges.size());
  SearchedMaximum found = BoxSearch(along_x, all, enough).run(boxes);
  found.at.conservativeResize(static_cast<Eigen::Index>(ranges.size()));
  return found;
}

std::size_t boxes_of_gap(double gap) {
  constexpr double at_one_percent = 0x1p17, most = 0x1p21;
  return static_cast<std::size_t>(std::min(most, at_one_percent * 0.01 / gap));
}

double rounding_allowance(const ErrorTerms& terms, const std::vector<Limits>& ranges) {
  return BoxBound(terms, ranges).rounding();
}

std::size_t influential_joints(const ErrorTerms& terms, const std::vector<Limits>& ranges) {
  const bool turned = terms.length() && !terms.sigma();
  const ErrorTerms along_x = turned ? terms.along_any_direction(ranges.size()) : terms;
  const std::vector<Limits> all = turned ? with_base(ranges) : ranges;
  const BoxBound bound(along_x, all);
  std::size_t count = 0;
  for (std::size_t j = 0; j < all.size(); ++j) count += bound.matters(j) && all[j].lower < all[j].upper;
  return count;
}

}  // namespace qerr
