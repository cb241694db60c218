// Moves the border between two labels of a map away from the middle of edges, so that every label
// keeps its volume.
//
// Samples with a different label among their 26 neighbors are *border samples*. Each has one
// magnitude, the same for all labels: on an edge between samples of magnitudes a and b with
// different labels, the border is at a / (a + b) of the edge. Two touching labels therefore have
// the same border, even next to a third one.
//
// Magnitudes start as border_samples.hpp describes, and border_smoothing.hpp smooths them. Both
// take from thin parts and convex ones, so several rounds correct them: each sample of a label
// should contribute an eighth of a cell of eight samples to the label's volume. Where the
// framework's tetrahedra hold less, the difference is the label's shortfall in the cell. It is
// averaged over the label's nearby border samples, whose magnitudes grow with it. Where a label is
// thick, only the first round corrects, by less: on smooth slopes, nearby shortfalls differ, too.
//
// Guaranteed: the samples of a slice depend on no label farther away than kLabelReach samples along
// an axis, so a border is a function of its neighborhood.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "common/base/scratch_file.hpp"
#include "server/volume/labels/border_samples.hpp"

namespace multitetra {

// Search 6, smoothing 4 x 2, and 7 rounds of a cell and 6 averagings.
inline constexpr std::int32_t kLabelReach = 6 + 4 * 2 + 7 * (1 + 6);

class LabelBorders {
 public:
  // Reads slices several times, each time in order. Stores magnitudes in an unnamed file in
  // `scratch_folder`. Throws what `read` throws, and std::system_error if the disk fails.
  LabelBorders(const LabelDims& dims, const ReadLabels& read,
               const std::filesystem::path& scratch_folder);

  // Returns the samples of slice z.
  void get(std::int32_t z, std::span<BorderSample> into) const;
  // Returns, for each label with a border, its number of samples minus the volume inside its
  // surface, in sample volumes.
  [[nodiscard]] const std::map<std::int32_t, double>& shortfalls() const { return shortfalls_; }

 private:
  class Round;

  LabelDims dims_;
  std::unique_ptr<ScratchFile> scratch_;
  // Number of border samples of each slice.
  std::vector<std::uint32_t> border_samples_;
  std::map<std::int32_t, double> shortfalls_;
};

}  // namespace multitetra
