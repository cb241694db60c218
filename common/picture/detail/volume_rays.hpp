// The light of a volume along the line of sight of a pixel, between any two depths.
#pragma once

#include <cstdint>
#include <vector>

#include "common/picture/camera.hpp"
#include "common/picture/detail/layers.hpp"
#include "common/picture/volume.hpp"

namespace multitetra {

// Opacities as extinctions per voxel, and their integral over the values.
class ExtinctionTable {
 public:
  // Requires at least one point.
  explicit ExtinctionTable(const std::vector<OpacityPoint>& points);

  // Returns the mean extinction of the values between two.
  [[nodiscard]] double mean(double one, double other) const;

 private:
  struct Entry {
    double extinction = 0;
    double integral = 0;  // Up to here, from the first value on.
  };
  [[nodiscard]] Entry at(double value) const;

  double first_ = 0;
  double spacing_ = 0;  // Of the entries' values; positive.
  std::vector<Entry> entries_;
};

// Places at equal distances on the line of sight.
class VolumeRay {
 public:
  // Returns the light of the part between two depths along Camera::back, and what it lets pass.
  [[nodiscard]] Mix between(double near, double far) const;

 private:
  friend class VolumeRays;
  [[nodiscard]] Mix up_to(double depth) const;
  [[nodiscard]] Mix largest_between(double near, double far) const;

  const DrawnVolume* volume_ = nullptr;
  double first_ = 0;  // The depth of the first place.
  double spacing_ = 1;
  std::vector<Mix> sums_;      // Of all in front of each place.
  std::vector<float> values_;  // With is_maximum: at each place; NaN for none.
};

class VolumeRays {
 public:
  // Both must outlive it.
  VolumeRays(const DrawnVolume& volume, const Camera& camera);

  // Makes `ray` that of the center of a pixel.
  void trace(int x, int y, VolumeRay& ray) const;

 private:
  // The values of a block of cells, with the samples at its border.
  struct Block {
    float low = 0;
    float high = -1;  // Below `low` without values.
    bool is_visible = false;
  };

  void measure_blocks();
  [[nodiscard]] float value_at(const Vec3& index) const;
  [[nodiscard]] const Block& block_at(const Vec3& index, Vec3& first) const;
  [[nodiscard]] Light light_at(const Vec3& index, double value, const Vec3& direction) const;

  const DrawnVolume& volume_;
  const Camera& camera_;
  Affine to_index_;
  ExtinctionTable extinctions_;
  std::array<std::size_t, 3> block_counts_ = {};
  std::vector<Block> blocks_;
};

}  // namespace multitetra
