// The expected range of a surface's size, given its estimate.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace multitetra {

// Most surfaces have 0.75 to 1.5 times the estimated triangles, as measured by
// tests/bench/budgets.py. The viewer uses the same factors (client/web/src/shared/quantities.ts); a
// test compares them.
inline constexpr double kMinEstimateFactor = 0.75;
inline constexpr double kMaxEstimateFactor = 1.5;

struct TriangleRange {
  std::uint64_t least = 0;
  std::uint64_t most = 0;
};

// Returns the range, rounded outward to two significant digits. `budget` is the maximum number of
// triangles, which surfaces never exceed; 0: no limit.
[[nodiscard]] inline TriangleRange expected_triangles(std::uint64_t estimate,
                                                      std::uint64_t budget) {
  const auto in_two_digits = [](double count, double (*rounded)(double)) {
    const double digits = count < 1 ? 1 : std::floor(std::log10(count)) + 1;
    const double unit = std::pow(10.0, std::max(0.0, digits - 2));
    return static_cast<std::uint64_t>(rounded(count / unit) * unit);
  };
  const auto count = static_cast<double>(estimate);
  TriangleRange range = {
      .least = in_two_digits(kMinEstimateFactor * count, [](double x) { return std::floor(x); }),
      .most = in_two_digits(kMaxEstimateFactor * count, [](double x) { return std::ceil(x); })};
  if (budget > 0) range.most = std::min(range.most, budget);
  range.least = std::min(range.least, range.most);
  return range;
}

}  // namespace multitetra
