// Estimates of a step's time: on the server, on the link and in the client.
#pragma once

#include <algorithm>

namespace multitetra {

struct SurfaceSize {
  double triangles = 0;
  double bytes = 0;      // Encoded size.
  double extracted = 0;  // Triangles before simplification, which determine the time.
};

// Assumed bandwidth before the first measurement: 10 Mbit/s.
inline constexpr double kDefaultBytesPerSecond = 1.25e6;

// The form of a step's tiles.
enum class StepForm { kPlain, kSimplified, kIntersectionFree, kShells };

[[nodiscard]] inline bool is_simplified(StepForm form) {
  return form == StepForm::kSimplified || form == StepForm::kIntersectionFree;
}

// Seconds per extracted triangle, summed over all threads.
struct CostEstimates {
  // To extract and encode it.
  double plain = 0.4e-6;
  // To extract, simplify and encode it.
  double simplified = 2.5e-6;
  // To extract it, simplify it without self-intersections and encode it.
  double intersection_free = 5e-6;
  // To encode the samples around it.
  double shells = 0.03e-6;
  double bytes_per_second = kDefaultBytesPerSecond;
  double client_triangles_per_second = 0;  // 0 if the client's time is ignored.

  [[nodiscard]] double seconds_per_triangle(StepForm form) const {
    switch (form) {
      case StepForm::kSimplified:
        return simplified;
      case StepForm::kIntersectionFree:
        return intersection_free;
      case StepForm::kShells:
        return shells;
      default:
        return plain;
    }
  }
  [[nodiscard]] double server_seconds(const SurfaceSize& size, StepForm form) const {
    return kSecondsPerStep + size.extracted * seconds_per_triangle(form);
  }
  [[nodiscard]] double link_seconds(const SurfaceSize& size) const {
    return size.bytes / bytes_per_second;
  }
  // Returns the time to decode, check and display it.
  [[nodiscard]] double client_seconds(const SurfaceSize& size) const {
    if (client_triangles_per_second <= 0) return 0;
    return size.triangles / std::max(client_triangles_per_second, 1.0);
  }

  static constexpr double kSecondsPerStep = 2e-3;  // Independent of the step's content.
};

// Measured costs of past steps on this machine, recent ones weighted most. Pure.
class MeasuredCosts {
 public:
  // Records that a step with `extracted` extracted triangles took `seconds`.
  void record(StepForm form, double extracted, double seconds);
  [[nodiscard]] const CostEstimates& costs() const { return costs_; }

 private:
  CostEstimates costs_;
};

}  // namespace multitetra
