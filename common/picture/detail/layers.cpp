#include "common/picture/detail/layers.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace multitetra {
namespace {

// `layers`: the fragments that cover the sample, nearest first.
Mix mixed(std::span<const Fragment* const> layers, std::size_t sample) {
  Mix mix;
  for (const Fragment* layer : layers) {
    const Light& light = (layer->wires >> sample & 1) != 0 ? layer->wire : layer->light;
    for (std::size_t j = 0; j < 3; ++j) mix.light[j] += mix.passing * layer->opacity * light[j];
    mix.passing *= 1 - layer->opacity;
  }
  return mix;
}

}  // namespace

std::vector<Mix> mixes_of(std::vector<Fragment> fragments, std::size_t pixels) {
  if (fragments.empty()) return {};
  std::vector<Mix> mixes(pixels * kSamples);
  std::stable_sort(fragments.begin(), fragments.end(),
                   [](const Fragment& a, const Fragment& b) { return a.pixel < b.pixel; });
  std::vector<const Fragment*> layers;
  for (std::size_t first = 0, last = 0; first < fragments.size(); first = last) {
    const std::uint32_t pixel = fragments[first].pixel;
    while (last < fragments.size() && fragments[last].pixel == pixel) ++last;
    for (std::size_t i = 0; i < kSamples; ++i) {
      layers.clear();
      for (std::size_t f = first; f < last; ++f) {
        if ((fragments[f].covered >> i & 1) != 0) layers.push_back(&fragments[f]);
      }
      std::stable_sort(layers.begin(), layers.end(), [i](const Fragment* a, const Fragment* b) {
        return a->nearness[i] > b->nearness[i];
      });
      mixes[pixel * kSamples + i] = mixed(layers, i);
    }
  }
  return mixes;
}

Pixel pixel_of(std::span<const Sample, kSamples> samples, std::span<const Mix> mixes,
               const Light& behind, bool has_background) {
  assert(mixes.empty() || mixes.size() == kSamples);
  Light sum = {0, 0, 0};
  float seen = 0;  // Samples, counting transparent ones in part.
  for (std::size_t i = 0; i < kSamples; ++i) {
    const bool is_hit = samples[i].nearness > 0;
    const Light& last = is_hit ? samples[i].light : behind;
    const Mix mix = mixes.empty() ? Mix{} : mixes[i];
    const float of_last = is_hit || has_background ? mix.passing : 0;
    seen += 1 - mix.passing + of_last;
    for (std::size_t j = 0; j < 3; ++j) sum[j] += mix.light[j] + of_last * last[j];
  }
  if (seen == 0) return {0, 0, 0, 0};
  return {srgb_from(sum[0] / seen), srgb_from(sum[1] / seen), srgb_from(sum[2] / seen),
          static_cast<std::uint8_t>(std::lround(255 * seen / kSamples))};
}

}  // namespace multitetra
