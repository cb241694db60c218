// A prepared dataset that tests write, and its expected contents. small_prepared is in the golden
// file small.mtd.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "server/core/framework/volume.hpp"
#include "server/core/spectrum/sample_bricks.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"
#include "server/dataset/dataset_writer.hpp"
#include "server/dataset/detail/statistics.hpp"
#include "server/dataset/prepared_file.hpp"
#include "tests/support/memory_source.hpp"

namespace multitetra {

[[nodiscard]] inline std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text));
}

[[nodiscard]] inline std::string text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

struct PreparedExample {
  DatasetMetadata metadata;
  std::vector<std::string> sample_bricks;
  std::vector<std::string> spectrum_bricks;
  std::string coarse;  // Has the required length and any content.
  std::string ranges;
  std::string bins;
};

// Returns the samples of each brick in the order of the layout.
[[nodiscard]] inline std::vector<std::string> bricks_of(const Volume& volume) {
  const BrickLayout layout(volume.dims);
  std::vector<std::string> bricks(layout.size());
  const auto put = [&](const auto& samples, std::int32_t x, std::int32_t y, std::int32_t z) {
    const auto sample = samples[volume.index(x, y, z)];
    constexpr std::int32_t kSide = BrickLayout::kSampleSide;
    bricks[layout.index({x / kSide, y / kSide, z / kSide})].append(
        reinterpret_cast<const char*>(&sample), sizeof(sample));
  };
  for (std::int32_t z = 0; z < volume.dims[2]; ++z) {
    for (std::int32_t y = 0; y < volume.dims[1]; ++y) {
      for (std::int32_t x = 0; x < volume.dims[0]; ++x) {
        std::visit([&](const auto& samples) { put(samples, x, y, z); }, volume.samples);
      }
    }
  }
  return bricks;
}

// The spectrum has one empty brick, and others of several sizes.
[[nodiscard]] inline PreparedExample prepared_example(const Volume& volume) {
  PreparedExample example;
  example.metadata = {.info = describe(volume, "small", 0.0, 0),
                      .source = {.file = "small.nrrd", .digest = "0123"},
                      .program_version = "0.1.0"};
  example.sample_bricks = bricks_of(volume);
  example.coarse.resize(coarse_bytes(example.metadata.info));
  example.ranges.resize(ranges_bytes(example.metadata.info));
  for (std::size_t i = 0; i < example.coarse.size(); ++i) {
    example.coarse[i] = static_cast<char>('a' + i % 7);
  }
  for (std::size_t i = 0; i < example.ranges.size(); ++i) {
    example.ranges[i] = static_cast<char>('k' + i % 11);
  }
  example.spectrum_bricks.resize(SpectrumLayout(example.metadata.info).size());
  for (std::size_t i = 0; i < example.spectrum_bricks.size(); ++i) {
    if (i % 4 != 2) example.spectrum_bricks[i].assign(3 + 7 * (i % 5), static_cast<char>('a' + i));
  }
  return example;
}

// 34 x 2 x 2 samples: three bricks; four bricks of the spectrum, of which the third is empty.
[[nodiscard]] inline PreparedExample small_prepared() {
  Volume volume;
  volume.dims = {34, 2, 2};
  volume.spacing = {0.5, 1, 2};
  volume.index_to_world = {.columns = {Vec3{0.5, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 2}},
                           .translation = {-1, 0, 10}};
  std::vector<std::int16_t> samples(volume.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i] = static_cast<std::int16_t>((i % 34 + 2 * (i / 34)) % 7);
  }
  volume.samples = std::move(samples);
  PreparedExample example = prepared_example(volume);
  // Fixed, because the golden file pins a format.
  example.metadata.info.suggested_isovalues = {1.5};
  return example;
}

// Adds the bricks of the spectrum in an order other than their numbers.
inline void add_spectrum(DatasetWriter& writer, const PreparedExample& example) {
  for (std::size_t i = example.spectrum_bricks.size(); i-- > 0;) {
    writer.add_spectrum_brick(i, bytes_of(example.spectrum_bricks[i]));
  }
}

inline void add_samples(DatasetWriter& writer, const PreparedExample& example) {
  for (const std::string& brick : example.sample_bricks) writer.add_samples(bytes_of(brick));
}

inline void finish(DatasetWriter& writer, const PreparedExample& example) {
  writer.finish(example.metadata, {.coarse = bytes_of(example.coarse),
                                   .ranges = bytes_of(example.ranges),
                                   .bins = bytes_of(example.bins)});
}

inline void write_prepared(const std::filesystem::path& path, const PreparedExample& example) {
  DatasetWriter writer(path, example.metadata.info);
  add_samples(writer, example);
  add_spectrum(writer, example);
  finish(writer, example);
}

[[nodiscard]] inline std::string text_of(const RetainedBytes& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

[[nodiscard]] inline std::vector<std::string> all_bricks(const PreparedBricks& source) {
  std::vector<std::string> bricks;
  for (std::size_t i = 0; i < source.size(); ++i) bricks.push_back(text_of(source.brick(i)));
  return bricks;
}

// Opens bytes in memory as a file; they must outlive it.
[[nodiscard]] inline BrickFile brick_file(std::span<const std::byte> bytes,
                                          PreparedStructure structure) {
  return {.place = "memory",
          .source = std::make_shared<const MemorySource>(bytes),
          .structure = std::make_shared<const PreparedStructure>(std::move(structure)),
          .cache = std::make_shared<MemoryCache>(std::size_t{1} << 20)};
}

inline void expect_holds(const PreparedFile& file, const PreparedExample& example) {
  EXPECT_EQ(file.metadata(), example.metadata);
  EXPECT_EQ(all_bricks(*file.samples()), example.sample_bricks);
  EXPECT_EQ(all_bricks(*file.spectrum()), example.spectrum_bricks);
  EXPECT_EQ(text_of(file.coarse()), example.coarse);
  EXPECT_EQ(text_of(file.ranges()), example.ranges);
  EXPECT_EQ(text_of(file.bins()), example.bins);
}

}  // namespace multitetra
