// Blends the translucent layers of each sample in order of depth, nearest first, with the nearest
// solid surface behind them, however the surfaces nest (an A-buffer; Carpenter 1984).
//
//   triangles --> Sample: the nearest solid one -------------+
//             \-> Fragment: each that is seen through -> Mix +-> Pixel
//   volume ----> the parts between them -------------------^
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "common/image/picture.hpp"
#include "common/picture/shading.hpp"

namespace multitetra {

inline constexpr std::size_t kSamples = 8;  // Per pixel.

// The nearest solid surface at a sample.
struct Sample {
  double nearness = 0;  // The reciprocal of the depth; 0: no surface.
  Light light = {};
};

// The contribution of a translucent triangle to a pixel.
struct Fragment {
  std::uint32_t pixel = 0;  // Index among the pixels drawn together.
  // One bit per covered sample.
  std::uint8_t covered = 0;
  // One bit per covered sample that lies on a wire.
  std::uint8_t wires = 0;
  float opacity = 1;
  Light light = {};
  Light wire = {};
  std::array<float, kSamples> nearness = {};  // At the covered samples.
};

// The translucent layers in front of a sample's solid surface, blended.
struct Mix {
  Light light = {0, 0, 0};  // The light that reaches the eye.
  float passing = 1;        // The fraction of the light behind that passes.
};

// A volume on the line of sight of a pixel.
struct VolumePart {
  // Returns what it adds between two depths; null: no volume.
  std::function<Mix(double near, double far)> between = nullptr;
  // False: it has no order, such as the largest value, and lies behind all layers.
  bool has_order = true;
};

// Returns the mix of every sample, kSamples per pixel; empty without fragments and volume. Among
// fragments of equal depth the first is in front. Requires that all fragments belong to these
// pixels and lie in front of the samples' solid surfaces. `volume_at`: called once for each pixel,
// in order; null: no volume.
[[nodiscard]] std::vector<Mix> mixes_of(
    std::vector<Fragment> fragments, std::span<const Sample> samples,
    const std::function<VolumePart(std::uint32_t pixel)>& volume_at = nullptr);

// Returns the mean of a pixel's samples; `mixes` is empty or has one per sample. Where nothing is
// hit, shows `behind` if there is a background; otherwise the pixel is transparent.
[[nodiscard]] Pixel pixel_of(std::span<const Sample, kSamples> samples, std::span<const Mix> mixes,
                             const Light& behind, bool has_background);

}  // namespace multitetra
