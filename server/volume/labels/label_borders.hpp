// Moves the border between two labels of a map away from the middle of edges, so that every label
// keeps its volume.
//
// Samples with a different label among their 26 neighbors are *border samples*. Each has one
// magnitude, the same for all labels: on an edge between samples of magnitudes a and b with
// different labels, the border is at a / (a + b) of the edge. Two touching labels therefore have
// the same border, even next to a third one.
//
// Magnitudes start as the smoothed indicator of the label minus one half. Smoothing removes thin
// parts, so several rounds correct them: each sample of a label should contribute an eighth of a
// cell of eight samples to the label's volume. Where the framework's tetrahedra hold less, the
// difference is the label's shortfall in the cell. It is averaged over the label's nearby border
// samples, whose magnitudes grow with it.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "common/base/scratch_file.hpp"

namespace multitetra {

class LabelBorders {
 public:
  using Dims = std::array<std::int32_t, 3>;
  // Reads the labels of slice z.
  using ReadSlice = std::function<void(std::int32_t z, std::span<std::int32_t> into)>;

  // Range of magnitudes, in 1/256 of the field's range.
  static constexpr int kMin = 4;
  static constexpr int kMax = 128;

  // Reads slices several times, each time in order. Stores magnitudes in an unnamed file in
  // `scratch_folder`. Throws what `read` throws, and std::system_error if the disk fails.
  LabelBorders(const Dims& dims, const ReadSlice& read,
               const std::filesystem::path& scratch_folder);

  // Returns kMin to kMax for the border samples of slice z, and 0 for all others.
  void magnitudes(std::int32_t z, std::span<std::uint8_t> into) const;
  // Returns, for each label with a border, its number of samples minus the volume inside its
  // surface, in sample volumes.
  [[nodiscard]] const std::map<std::int32_t, double>& shortfalls() const { return shortfalls_; }

 private:
  class Round;

  Dims dims_;
  std::unique_ptr<ScratchFile> scratch_;
  // Number of border samples of each slice.
  std::vector<std::uint32_t> border_samples_;
  std::map<std::int32_t, double> shortfalls_;
};

}  // namespace multitetra
