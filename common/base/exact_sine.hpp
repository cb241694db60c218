// Sine and cosine with the same bits on every machine, unlike those of the C library, which may
// differ between versions.
#pragma once

#include <cmath>
#include <numbers>

namespace multitetra {

// sin(2 pi turns), within 1e-15. Reduces to a quarter turn and sums the Taylor series, whose next
// term is below 1e-17 there. Only additions and multiplications, so the result is the same wherever
// doubles are IEEE 754 and the compiler does not contract them.
[[nodiscard]] inline double sine_of_turns(double turns) {
  double t = turns - std::round(turns);
  if (std::abs(t) > 0.25) t = std::copysign(0.5, t) - t;
  const double x = 2 * std::numbers::pi * t;
  double sum = 0;
  for (int k = 21; k >= 1; k -= 2) {
    // Horner's scheme for x - x^3/3! + x^5/5! - ...: each step divides by the next two factors.
    sum = 1 - x * x / static_cast<double>((k + 1) * (k + 2)) * sum;
  }
  return x * sum;
}

[[nodiscard]] inline double cosine_of_turns(double turns) { return sine_of_turns(turns + 0.25); }

}  // namespace multitetra
