// A label map (a segmentation: each sample is the number of a structure), and each of its labels as
// a smooth field whose isosurface 0.5 is the label's boundary.
//
//   const auto source = open_volume("seg.nii.gz");
//   const LabelMap map("seg.nii.gz", *source, "/var/tmp");   // Reads the source once.
//   for (const LabelSummary& label : map.labels()) prepare(*map.field(label.value), ...);
//
// The field is f32 with values n / 256, n from 0 to 256. Next to another label it is one half plus
// (inside the label) or minus (outside) the sample's magnitude, see label_borders.hpp; elsewhere it
// is the label's indicator, smoothed along each axis by the weights 1 4 6 4 1 (over 16) and
// rounded. Beyond the ends of the map, surfaces close about half a sample away, in a layer of
// samples that are kBeyondEnds.
//
// Guaranteed:
// * Every sample is on its side of 0.5, by at least 4/256: the isosurface cuts exactly those edges
//   of the grid that leave the label. Thin parts stay, and nothing merges.
// * Two touching labels (background is one) have the same crossing on every edge between them, so
//   they have the same triangles except in tetrahedra with a third label, where gaps of less than
//   a step may remain. If a map has two labels, their fields add up to 1.
// * The volume inside the surface of a label is known: LabelSummary::surface_samples.
// * The field at a sample depends on no label more than kLabelReach samples away along an axis.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "server/volume/volume_source.hpp"

namespace multitetra {

inline constexpr double kLabelBoundary = 0.5;

// Bins of isovalues for such fields. The bin around the boundary contains no value of the field, so
// errors there are nearly exact. Symmetric, since fields of complements are.
inline constexpr std::array<float, 12> kLabelBinEdges = {0x20p-8F, 0x40p-8F, 0x60p-8F, 0x70p-8F,
                                                         0x78p-8F, 0x7Fp-8F, 0x81p-8F, 0x88p-8F,
                                                         0x90p-8F, 0xA0p-8F, 0xC0p-8F, 0xE0p-8F};

inline constexpr std::size_t kMaxLabels = 65'536;

struct LabelSummary {
  double value = 0;  // An integer.
  std::uint64_t samples = 0;
  // The volume inside the surface at error 0, in sample volumes. Surfaces that are open at the ends
  // of the map count as if they closed half a sample beyond.
  double surface_samples = 0;
  // Number of samples in parts one sample thick (thin_parts.hpp).
  std::uint64_t thin_samples = 0;
  std::array<std::int32_t, 3> least = {};     // Least sample indices.
  std::array<std::int32_t, 3> greatest = {};  // Greatest sample indices.
  std::array<double, 3> centroid = {};        // Mean sample index.
};

// Where surfaces end that reach the ends of the map: they close in a layer of samples around the
// map, or stay open at the last samples.
enum class LabelEnds { kClosed, kOpen };

// The value of that layer: on the outer side of a plane border (see border_samples.hpp).
inline constexpr double kBeyondEnds = kLabelBoundary - 0x24p-8;

// A box of samples; both corners are inclusive.
struct SampleBox {
  std::array<std::int32_t, 3> least = {};
  std::array<std::int32_t, 3> greatest = {};
};

// Returns whether the label reaches the ends of a map of `dims` samples.
[[nodiscard]] bool meets_end(const LabelSummary& label, const std::array<std::int32_t, 3>& dims);

// Copies share the samples.
class LabelMap {
 public:
  // Copies `source` into a scratch file in `scratch_folder`. `name` is the source's name in
  // messages. Throws VolumeFileError as the source does, if a sample is not an integer that f32
  // represents exactly, or if there are more than kMaxLabels; std::system_error if the disk fails;
  // Cancelled soon after `stop` is triggered.
  LabelMap(const std::filesystem::path& name, VolumeSource& source,
           const std::filesystem::path& scratch_folder, LabelEnds ends = LabelEnds::kClosed,
           const std::stop_token& stop = {});

  // Returns the labels that occur, sorted, without the background 0. Void samples have no label.
  [[nodiscard]] std::span<const LabelSummary> labels() const;

  // Returns the field of a label, including the background and labels that do not occur. It
  // streams, holding a few slices in memory. Void samples count as outside of every label.
  [[nodiscard]] std::unique_ptr<VolumeSource> field(double value) const;

 private:
  struct Content;
  class Field;
  std::shared_ptr<const Content> content_;
};

}  // namespace multitetra
