// Offsets of the border between two labels of a map from the middle, so that every label keeps
// its volume.
//
// Samples that have another label among their 26 neighbours are *border samples*. Each has one
// magnitude, whatever label is looked at: along an edge between samples of magnitudes a and b with
// different labels, the border is at a / (a + b) of the edge. So two labels that touch have the
// same border, also beside a third one.
//
// Magnitudes begin as the label's indicator, smoothed, above one half. Smoothing makes thin parts
// vanish, so that they are corrected in rounds: a cell of eight samples should hold an eighth for
// each sample of a label; what the framework's tetrahedra hold less of the label is its shortfall
// there. It is averaged over the label's border samples around, and their magnitudes grow with it.
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
  // Writes the labels of slice z.
  using ReadSlice = std::function<void(std::int32_t z, std::span<std::int32_t> into)>;

  // Magnitudes in 1/256 of the field's range.
  static constexpr int kLeast = 4;
  static constexpr int kMost = 128;

  // Reads slices several times, each time in order. Magnitudes are put into a file without a name
  // in `scratch_folder`. Throws what `read` does, and std::system_error when the disk fails.
  LabelBorders(const Dims& dims, const ReadSlice& read,
               const std::filesystem::path& scratch_folder);

  // From kLeast to kMost at border samples of slice z, 0 at all others.
  void magnitudes(std::int32_t z, std::span<std::uint8_t> into) const;
  // The samples that a label has more than its surface holds, in volumes of a sample. Of the labels
  // that have a border.
  [[nodiscard]] const std::map<std::int32_t, double>& shortfalls() const { return shortfalls_; }

 private:
  class Round;

  Dims dims_;
  std::unique_ptr<ScratchFile> scratch_;
  // Border samples of every slice.
  std::vector<std::uint32_t> border_samples_;
  std::map<std::int32_t, double> shortfalls_;
};

}  // namespace multitetra
