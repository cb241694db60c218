// Fields prepared in memory, covering all cases that the error spectrum must handle.
#pragma once

#include <optional>
#include <ostream>
#include <random>
#include <string>
#include <vector>

#include "server/volume/generators/generators.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/make_dataset.hpp"
#include "tests/support/volume_in_memory.hpp"

namespace multitetra::testing {

struct PreparedSetting {
  std::string name;
  Volume volume;
  std::optional<double> outside = std::nullopt;
  std::int32_t margin = 0;
  bool samples_only = false;
};

inline std::ostream& operator<<(std::ostream& out, const PreparedSetting& setting) {
  return out << setting.name;
}

// Values over eight orders of magnitude: with uniform bins nearly all would be in one.
inline Volume skewed_noise(std::array<std::int32_t, 3> dims, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  return fields::sampled<float>(
      dims, [&](int, int, int) { return std::exp(18 * fields::uniform(random)); }, {1, 2, 0.7});
}

inline std::vector<PreparedSetting> settings_of_noise_and_shapes() {
  return {
      {"noise", fields::noise({19, 26, 40}, 3)},
      {"flat_noise_in_zeros", fields::noise({35, 18, 3}, 4, {0.5, 1, 3}), 0.0, 1},
      {"plateaus", fields::integer_noise({33, 17, 21}, 5, 5), std::nullopt, 2},
      {"integers_in_a_large_value", fields::integer_noise({33, 17, 21}, 50, 6), 300.5, 3},
      {"integers_in_a_value", fields::integer_noise({30, 17, 21}, 200, 7), 20.0, 1},
      {"gyroid", fields::gyroid(33, 0.3, 8)},
      {"stretched_gyroid_in_a_value", fields::gyroid(29, 0.1, 9, {1, 1.3, 2}), 0.0, 1},
      {"ball", fields::ball({33, 33, 33}, 12)},
      {"masked_gyroid", fields::masked_gyroid(33, 10)},
      {"masked_gyroid_in_a_value", fields::masked_gyroid(27, 11), -1.0, 5},
      {"skewed", skewed_noise({22, 31, 18}, 12), std::nullopt, 7},
      {"slice", fields::noise({40, 33, 1}, 13), 0.0, 1},
  };
}

inline std::vector<PreparedSetting> prepared_settings() {
  std::vector<PreparedSetting> settings = settings_of_noise_and_shapes();
  for (const GeneratorKind kind : kGeneratorKinds) {
    settings.push_back(
        {"generated_" + std::string(name(kind)), generate(kind, {.size = 41, .noise = 0.02})});
  }
  for (PreparedSetting& setting : settings) {
    for (char& c : setting.name) c = c == '-' ? '_' : c;
  }
  return settings;
}

inline DatasetPtr prepared(const PreparedSetting& setting, int bins = IsovalueBins::kDefaultCount) {
  return make_dataset(*source_of(setting.volume), {.name = setting.name,
                                                   .outside = setting.outside,
                                                   .margin = setting.margin,
                                                   .bins = bins,
                                                   .samples_only = setting.samples_only});
}

// Returns settings without errors.
inline std::vector<PreparedSetting> settings_without_errors() {
  std::vector<PreparedSetting> settings = settings_of_noise_and_shapes();
  for (PreparedSetting& setting : settings) {
    setting.name += "_without_errors";
    setting.samples_only = true;
  }
  return settings;
}

// Returns isovalues of a dataset: between its values, at them, at edges of bins.
inline std::vector<double> isovalues_of(const PreparedVolume& dataset) {
  const double low = dataset.info.min;
  const double extent = dataset.info.max - low;
  std::vector<double> isovalues = {low + 0.17 * extent, low + 0.5 * extent, low + 0.83 * extent};
  const auto& edges = dataset.spectrum.bins.edges();
  if (edges.size() > 4) isovalues.push_back(static_cast<double>(edges[edges.size() / 3]));
  return isovalues;
}

}  // namespace multitetra::testing
