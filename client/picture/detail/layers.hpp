// The translucent layers behind each sample of some pixels, in order of depth, and the
// color that comes of it: the nearest solid surface, and before it all that is seen through, the
// nearest first, however these nest (an A-buffer; Carpenter 1984).
//
//   triangles --> Sample: the nearest solid one -------------+
//             \-> Fragment: each that is seen through -> Mix +-> Pixel
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "client/picture/shading.hpp"
#include "common/image/picture.hpp"

namespace multitetra {

inline constexpr std::size_t kSamples = 8;  // Per pixel.

// The solid surface that a sample shows.
struct Sample {
  double nearness = 0;  // One by the distance along the view; 0: of nothing.
  Light light = {};
};

// The contribution of a translucent triangle to a pixel.
struct Fragment {
  std::uint32_t pixel = 0;  // Among those that are drawn together.
  // A bit for each covered sample.
  std::uint8_t covered = 0;
  // A bit for each covered sample that lies on a wire.
  std::uint8_t wires = 0;
  float opacity = 1;
  Light light = {};
  Light wire = {};
  std::array<float, kSamples> nearness = {};  // At the samples that are covered.
};

// The translucent layers before a sample's opaque surface.
struct Mix {
  Light light = {0, 0, 0};  // As much as reaches the eye.
  float passing = 1;        // How much of what is behind does.
};

// The mix of every sample of so many pixels, kSamples after kSamples; of fragments that are equally
// near the first one is before the others. None where there is no fragment. Requires that fragments
// are of these pixels and lie before the samples' solid surfaces.
[[nodiscard]] std::vector<Mix> mixes_of(std::vector<Fragment> fragments, std::size_t pixels);

// The mean of a pixel's samples; `mixes` is empty or has one a sample. Where nothing is hit
// `behind` is seen, if there is a background; else the pixel is as transparent as its samples.
[[nodiscard]] Pixel pixel_of(std::span<const Sample, kSamples> samples, std::span<const Mix> mixes,
                             const Light& behind, bool has_background);

}  // namespace multitetra
