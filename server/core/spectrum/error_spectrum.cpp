#include "server/core/spectrum/error_spectrum.hpp"

#include <cmath>
#include <limits>
#include <string>

#include "server/core/spectrum/detail/error_codes.hpp"
#include "server/core/spectrum/detail/spectrum_brick.hpp"
#include "server/core/spectrum/detail/unknown_errors.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {

std::shared_ptr<const UnknownErrors> LatestUnknownErrors::of(const PreparedVolume& volume,
                                                             double isovalue) {
  const std::lock_guard lock(mutex_);
  if (!errors_ || isovalue_ != isovalue) {
    errors_ = std::make_shared<const UnknownErrors>(volume, isovalue);
    isovalue_ = isovalue;
  }
  return errors_;
}

SpectrumErrors::SpectrumErrors(const PreparedVolume& volume, double isovalue, ErrorMeasure measure,
                               TopologyRule rule)
    : spectrum_(volume.spectrum),
      unknown_(spectrum_.bricks ? nullptr : spectrum_.unknown->of(volume, isovalue)),
      bin_(spectrum_.bins.bin_of(isovalue)),
      measure_(measure),
      rule_(rule),
      planes_(spectrum_.layout.size()) {
  for (std::size_t code = 1; code < error_of_code_.size(); ++code) {
    const float value = error_codes().value(static_cast<std::uint8_t>(code)) * spectrum_.voxel;
    error_of_code_[code] = std::nextafter(value, std::numeric_limits<float>::infinity());
  }
}

SpectrumErrors::~SpectrumErrors() {
  for (const auto& plane : planes_) delete plane.load(std::memory_order_relaxed);
}

ErrorBound SpectrumErrors::bound(const DividingPoint& point) const {
  if (!bin_) return {};
  if (unknown_) return unknown_->bound(point);
  const SpectrumLayout::Level& level = spectrum_.layout.level(exponent_of(point.spacing()));
  const GridPoint unit_point = level.extent.unit_point(point.at());
  if (!level.extent.contains(unit_point)) return {};
  const SpectrumLayout::Place place = SpectrumLayout::place(level, unit_point);
  const Plane& p = plane(place.brick);
  return {.error = error_of_code_[p.error[place.point]],
          .flip_spacing = (1 << p.flip[place.point]) >> 1};
}

const SpectrumErrors::Plane& SpectrumErrors::plane(std::size_t brick) const {
  if (const Plane* known = planes_[brick].load(std::memory_order_acquire)) return *known;
  const auto decoded = decode_plane(spectrum_.bricks->brick(brick), *bin_);
  if (!decoded) throw DamagedSpectrumError(decoded.error().text);
  auto made = std::make_unique<Plane>();
  for (std::size_t i = 0; i < SpectrumLayout::kPoints; ++i) {
    const SpectrumPlane::Point& point = decoded->points[i];
    made->error[i] = measure_ == ErrorMeasure::kPaper ? point.paper : point.certified;
    made->flip[i] = rule_ == TopologyRule::kPaper ? point.flips & 15 : point.flips >> 4;
  }
  const Plane* expected = nullptr;  // If another thread was faster, its plane is the same.
  if (planes_[brick].compare_exchange_strong(expected, made.get(), std::memory_order_acq_rel)) {
    return *made.release();
  }
  return *expected;
}

}  // namespace multitetra
