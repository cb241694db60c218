// A label map (a segmentation: every sample is the number of the thing it belongs to), and each of
// its labels as a smooth field whose isosurface 0.5 is the label's boundary.
//
//   const auto source = open_volume("seg.nii.gz");
//   const LabelMap map("seg.nii.gz", *source, "/var/tmp");   // Reads the source once.
//   for (const LabelSummary& label : map.labels()) prepare(*map.field(label.value), ...);
//
// The field is f32 with values n / 256, n from 0 to 256. Beside another label it is one half plus
// (in the label) or minus (outside) the sample's magnitude, see label_borders.hpp; elsewhere the
// label's indicator, smoothed along each axis by the weights 1 4 6 4 1 (over 16) and rounded.
// Beyond the map's ends its last samples are repeated.
//
// Guaranteed:
// * Every sample is on its side of 0.5, by at least 4/256: the isosurface cuts exactly those edges
//   of the grid that lead out of the label. Thin parts stay, and nothing merges.
// * Two labels that touch (background is one) have the same crossing on every edge between them, so
//   the same triangles wherever no third label is within the tetrahedron; where three labels meet,
//   gaps of less than a step may stay. Where a map has two labels, their fields add up to 1.
// * What the surface holds of a label is known: LabelSummary::surface_samples.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "server/volume/volume_source.hpp"

namespace multitetra {

inline constexpr double kLabelBoundary = 0.5;

// Bins of isovalues for such fields: no value lies inside the one at the boundary, so that errors
// there are as good as exact; and they are the same from both ends, as complements are.
inline constexpr std::array<float, 12> kLabelBinEdges = {0x20p-8F, 0x40p-8F, 0x60p-8F, 0x70p-8F,
                                                         0x78p-8F, 0x7Fp-8F, 0x81p-8F, 0x88p-8F,
                                                         0x90p-8F, 0xA0p-8F, 0xC0p-8F, 0xE0p-8F};

inline constexpr std::size_t kMaxLabels = 65'536;

struct LabelSummary {
  double value = 0;  // Whole.
  std::uint64_t samples = 0;
  // The volume in the surface, in volumes of a sample. Of samples at the
  // map's ends the half beyond counts.
  double surface_samples = 0;
  // The samples in parts one sample thick (thin_parts.hpp).
  std::uint64_t thin_samples = 0;
  std::array<std::int32_t, 3> least = {};     // Indices of its samples, and
  std::array<std::int32_t, 3> greatest = {};  // the greatest ones.
  std::array<double, 3> centroid = {};        // The mean index.
};

// Indices of samples, first and last along each axis.
struct SampleBox {
  std::array<std::int32_t, 3> least = {};
  std::array<std::int32_t, 3> greatest = {};
};

// The field of a label in a map of `dims` samples is 0 outside of this box.
[[nodiscard]] SampleBox field_box(const LabelSummary& label,
                                  const std::array<std::int32_t, 3>& dims);

// Copies of a map share the samples.
class LabelMap {
 public:
  // Reads `source` once into a scratch file in `scratch_folder`. `name` is the source's name in
  // messages. Throws VolumeFileError when the source does, when a sample is no whole number that
  // f32 represents exactly, or when there are more than kMaxLabels; std::system_error when
  // the disk fails.
  LabelMap(const std::filesystem::path& name, VolumeSource& source,
           const std::filesystem::path& scratch_folder);

  // Those that occur, by value. 0 is the background and left out; void samples have no label.
  [[nodiscard]] std::span<const LabelSummary> labels() const;

  // The field of a label, also of one that does not occur, or of the background. It streams, and
  // needs memory for a few slices. Void samples count as outside of every label.
  [[nodiscard]] std::unique_ptr<VolumeSource> field(double value) const;

 private:
  struct Content;
  class Field;
  std::shared_ptr<const Content> content_;
};

}  // namespace multitetra
