// Estimates of a step's time: on the server, on the link and at the client.
#pragma once

#include <algorithm>

namespace multitetra {

struct SurfaceSize {
  double triangles = 0;
  double bytes = 0;      // Encoded.
  double extracted = 0;  // Triangles before simplification, which cost the time.
};

// Assumed bandwidth before the first measurement: 10 Mbit/s.
inline constexpr double kUsualBytesPerSecond = 1.25e6;

// The form of a step's tiles.
enum class StepForm { kPlain, kSimplified, kEmbedded, kShells };

[[nodiscard]] inline bool is_simplified(StepForm form) {
  return form == StepForm::kSimplified || form == StepForm::kEmbedded;
}

// In seconds, for each triangle that is extracted; all threads together.
struct CostEstimates {
  // Seconds a triangle to extract and encode it.
  double plain = 0.4e-6;
  // Seconds a triangle to extract, simplify and encode it.
  double simplified = 2.5e-6;
  // The same, but without self-intersections.
  double embedded = 5e-6;
  double shells = 0.03e-6;  // to encode the samples around it.
  double bytes_per_second = kUsualBytesPerSecond;
  double client_triangles_per_second = 0;  // 0: it takes no time.

  [[nodiscard]] double a_triangle(StepForm form) const {
    switch (form) {
      case StepForm::kSimplified:
        return simplified;
      case StepForm::kEmbedded:
        return embedded;
      case StepForm::kShells:
        return shells;
      default:
        return plain;
    }
  }
  [[nodiscard]] double server_seconds(const SurfaceSize& size, StepForm form) const {
    return kSecondsAStep + size.extracted * a_triangle(form);
  }
  [[nodiscard]] double link_seconds(const SurfaceSize& size) const {
    return size.bytes / bytes_per_second;
  }
  // To decode, to check and to show it.
  [[nodiscard]] double client_seconds(const SurfaceSize& size) const {
    if (client_triangles_per_second <= 0) return 0;
    return size.triangles / std::max(client_triangles_per_second, 1.0);
  }

  static constexpr double kSecondsAStep = 2e-3;  // Whatever is in it.
};

// Measured costs of past steps on this machine, recent ones weighted most. Pure.
class MeasuredCosts {
 public:
  // A step of so many extracted triangles took so long.
  void note(StepForm form, double extracted, double seconds);
  [[nodiscard]] const CostEstimates& costs() const { return costs_; }

 private:
  CostEstimates costs_;
};

}  // namespace multitetra
