#include "common/picture/detail/layers.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>

namespace multitetra {
namespace {

void add(const Mix& part, Mix& mix) {
  for (std::size_t j = 0; j < 3; ++j) mix.light[j] += mix.passing * part.light[j];
  mix.passing *= part.passing;
}

Mix mix_of(const Fragment& fragment, std::size_t sample) {
  const float opacity = fragment.opacity;
  const Light& light = (fragment.wires >> sample & 1) != 0 ? fragment.wire : fragment.light;
  return {.light = {opacity * light[0], opacity * light[1], opacity * light[2]},
          .passing = 1 - opacity};
}

// `layers`: the fragments that cover the sample, nearest first. `end`: the depth of what is solid.
Mix mixed(std::span<const Fragment* const> layers, std::size_t sample, double end,
          const VolumePart& volume) {
  Mix mix;
  double depth = 0;
  for (const Fragment* layer : layers) {
    const double next = 1 / layer->nearness[sample];
    if (volume.between && volume.has_order) add(volume.between(depth, next), mix);
    add(mix_of(*layer, sample), mix);
    depth = next;
  }
  if (volume.between) add(volume.between(volume.has_order ? depth : 0, end), mix);
  return mix;
}

}  // namespace

std::vector<Mix> mixes_of(std::vector<Fragment> fragments, std::span<const Sample> samples,
                          const std::function<VolumePart(std::uint32_t pixel)>& volume_at) {
  if (fragments.empty() && !volume_at) return {};
  std::vector<Mix> mixes(samples.size());
  std::stable_sort(fragments.begin(), fragments.end(),
                   [](const Fragment& a, const Fragment& b) { return a.pixel < b.pixel; });
  std::vector<const Fragment*> layers;
  std::size_t first = 0;
  for (std::uint32_t pixel = 0; pixel < samples.size() / kSamples; ++pixel) {
    std::size_t last = first;
    while (last < fragments.size() && fragments[last].pixel == pixel) ++last;
    if (first == last && !volume_at) continue;
    const VolumePart volume = volume_at ? volume_at(pixel) : VolumePart{};
    std::optional<Mix> unobstructed;  // Many samples see the volume alone.
    for (std::size_t i = 0; i < kSamples; ++i) {
      const double nearness = samples[pixel * kSamples + i].nearness;
      Mix& mix = mixes[pixel * kSamples + i];
      layers.clear();
      for (std::size_t f = first; f < last; ++f) {
        if ((fragments[f].covered >> i & 1) != 0) layers.push_back(&fragments[f]);
      }
      if (layers.empty() && nearness == 0 && unobstructed) {
        mix = *unobstructed;
        continue;
      }
      std::stable_sort(layers.begin(), layers.end(), [i](const Fragment* a, const Fragment* b) {
        return a->nearness[i] > b->nearness[i];
      });
      mix = mixed(layers, i, 1 / nearness, volume);
      if (layers.empty() && nearness == 0) unobstructed = mix;
    }
    first = last;
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
