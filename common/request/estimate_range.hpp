// How many triangles a surface has for which an estimate was made.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace multitetra {

// An estimate is mostly within a third of the real number; tests/bench/budgets.py measures it. The
// viewer has the same factors (client/web/src/shared/quantities.ts); a test compares them.
inline constexpr double kLeastOfEstimate = 0.75;
inline constexpr double kMostOfEstimate = 1.5;

struct TriangleRange {
  std::uint64_t least = 0;
  std::uint64_t most = 0;
};

// With two significant digits, the range rounded outward. `budget`: the most triangles that were
// allowed, which surfaces keep; 0: any number.
[[nodiscard]] inline TriangleRange expected_triangles(std::uint64_t estimate,
                                                      std::uint64_t budget) {
  const auto in_two_digits = [](double count, double (*rounded)(double)) {
    const double digits = count < 1 ? 1 : std::floor(std::log10(count)) + 1;
    const double unit = std::pow(10.0, std::max(0.0, digits - 2));
    return static_cast<std::uint64_t>(rounded(count / unit) * unit);
  };
  const auto count = static_cast<double>(estimate);
  TriangleRange range = {
      .least = in_two_digits(kLeastOfEstimate * count, [](double x) { return std::floor(x); }),
      .most = in_two_digits(kMostOfEstimate * count, [](double x) { return std::ceil(x); })};
  if (budget > 0) range.most = std::min(range.most, budget);
  range.least = std::min(range.least, range.most);
  return range;
}

}  // namespace multitetra
