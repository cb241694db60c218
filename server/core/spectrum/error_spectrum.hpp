// The stored errors of a prepared dataset, and their bounds for one isovalue.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <vector>

#include "common/request/isosurface_request.hpp"
#include "server/core/errors/saturated_errors.hpp"
#include "server/core/spectrum/isovalue_bins.hpp"
#include "server/core/spectrum/sample_bricks.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"

namespace multitetra {

// A brick of the spectrum is not one that SpectrumBrickBuilder makes.
class DamagedSpectrumError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct PreparedVolume;
class UnknownErrors;

// The bounds without stored errors for the isovalue requested last, shared by requests: a tile does
// not look at all cells again. Thread-safe.
class LatestUnknownErrors {
 public:
  [[nodiscard]] std::shared_ptr<const UnknownErrors> of(const PreparedVolume& volume,
                                                        double isovalue);

 private:
  std::mutex mutex_;  // Guards all members.
  double isovalue_ = 0;
  std::shared_ptr<const UnknownErrors> errors_;
};

// Upper bounds of the errors of all dividing points of spacing kSpectrumSpacing or more, for every
// isovalue. Immutable.
struct ErrorSpectrum {
  SpectrumLayout layout;
  IsovalueBins bins;
  float voxel = 1;  // The unit of errors, in world units.
  // In the format of spectrum_brick.hpp; null if the errors are unknown.
  std::shared_ptr<const BrickSource> bricks;
  std::shared_ptr<LatestUnknownErrors> unknown = std::make_shared<LatestUnknownErrors>();
};

// The bounds for one isovalue: never smaller than those of SaturatedErrors, and a parent's at least
// those of its children. Reads bricks on first use; without them, takes the errors of all points
// near the isosurface for infinite. Thread-safe. The volume must outlive it.
class SpectrumErrors {
 public:
  SpectrumErrors(const PreparedVolume& volume, double isovalue, ErrorMeasure measure,
                 TopologyRule rule);
  ~SpectrumErrors();
  SpectrumErrors(const SpectrumErrors&) = delete;
  SpectrumErrors& operator=(const SpectrumErrors&) = delete;

  // Requires point.spacing() >= kSpectrumSpacing. Throws DamagedSpectrumError.
  [[nodiscard]] ErrorBound bound(const DividingPoint& point) const;

 private:
  struct Plane {
    std::array<std::uint8_t, SpectrumLayout::kPoints> error;  // Error codes.
    std::array<std::uint8_t, SpectrumLayout::kPoints> flip;   // 0, or 1 + log2 of the spacing.
  };
  [[nodiscard]] const Plane& plane(std::size_t brick) const;

  const ErrorSpectrum& spectrum_;
  std::shared_ptr<const UnknownErrors> unknown_;  // Null if there are bricks.
  std::optional<int> bin_;
  ErrorMeasure measure_;
  TopologyRule rule_;
  std::array<float, 256> error_of_code_{};                 // World units.
  mutable std::vector<std::atomic<const Plane*>> planes_;  // By brick; null until first use.
};

}  // namespace multitetra
