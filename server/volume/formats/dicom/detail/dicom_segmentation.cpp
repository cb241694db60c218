#include "server/volume/formats/dicom/detail/dicom_segmentation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>

#include "common/base/number_text.hpp"
#include "common/base/vec3.hpp"
#include "server/volume/formats/detail/segment_names.hpp"
#include "server/volume/formats/dicom/detail/dicom_frames.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr double kFrameOnGrid = 0.1;  // Maximum deviation of a frame from its place, in steps.

using FramesOfSlices = std::vector<std::vector<DicomImage>>;
using Layers = std::map<std::int64_t, std::size_t>;  // The layer of each segment.

// Calls use(sample, segment) for each sample of a frame in a segment.
template <typename Use>
void for_each_in_segment(const DicomImage& image, std::span<const std::byte> samples,
                         const Use& use) {
  const auto each = [&](auto number) {
    const std::size_t count = samples.size() / sizeof(number);
    for (std::size_t i = 0; i < count; ++i) {
      std::memcpy(&number, samples.data() + i * sizeof(number), sizeof(number));
      const std::int64_t value = number;
      if (value == 0) continue;
      if (image.segmentation == Segmentation::kLabelMap) {
        use(i, value);
      } else if (2 * value >= image.largest_share || image.segmentation == Segmentation::kBinary) {
        use(i, image.segment);
      }
    }
  };
  if (bytes_of(image.type) == 1) {
    each(std::uint8_t{});
  } else {
    each(std::uint16_t{});
  }
}

// Assigns each segment the first layer in which it overlaps no segment that comes before it.
Layers layers_of(const std::set<std::int64_t>& segments,
                 const std::set<std::pair<std::int64_t, std::int64_t>>& overlaps) {
  Layers layers;
  for (const std::int64_t segment : segments) {
    std::set<std::size_t> taken;
    for (const auto& [low, high] : overlaps) {
      if (high == segment) taken.insert(layers.at(low));
    }
    std::size_t layer = 0;
    while (taken.contains(layer)) ++layer;
    layers[segment] = layer;
  }
  return layers;
}

// Finds layers without overlaps: sees only the first segment at each sample of a layer, so repeats
// until there are no further overlaps.
Layers separated_layers(const FramesOfSlices& slices, DicomFrames& frames) {
  std::set<std::int64_t> segments;
  for (const auto& slice : slices) {
    for (const DicomImage& frame : slice) segments.insert(frame.segment);
  }
  std::set<std::pair<std::int64_t, std::int64_t>> overlaps;
  Layers layers = layers_of(segments, overlaps);
  while (true) {
    const std::size_t known = overlaps.size();
    for (const auto& slice : slices) {
      std::map<std::size_t, std::vector<std::int64_t>> owners;  // By layer; 0 for none.
      for (const DicomImage& frame : slice) {
        auto& owner = owners[layers.at(frame.segment)];
        owner.resize(static_cast<std::size_t>(frame.size[0] * frame.size[1]));
        for_each_in_segment(frame, frames.samples(frame), [&](std::size_t i, std::int64_t segment) {
          if (owner[i] != 0 && owner[i] != segment) overlaps.insert(std::minmax(owner[i], segment));
          owner[i] = segment;
        });
      }
    }
    if (known == overlaps.size()) return layers;
    layers = layers_of(segments, overlaps);
  }
}

// Fractional samples are shares, of which the largest of a segment means all of it.
void set_largest_shares(FramesOfSlices& slices, DicomFrames& frames) {
  std::map<std::int64_t, std::int64_t> largest;
  for (const auto& slice : slices) {
    for (const DicomImage& frame : slice) {
      for (const std::byte share : frames.samples(frame)) {
        std::int64_t& of_segment = largest[frame.segment];
        of_segment = std::max<std::int64_t>(of_segment, std::to_integer<int>(share));
      }
    }
  }
  for (auto& slice : slices) {
    for (DicomImage& frame : slice) frame.largest_share = largest[frame.segment];
  }
}

class SegmentSlices : public StoredSlices {
 public:
  SegmentSlices(FramesOfSlices slices, Layers layers, const ImageHeader& header)
      : slices_(std::move(slices)), layers_(std::move(layers)), header_(header) {}

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    std::fill_n(into, count * header_.slice_bytes(), std::byte{0});
    for (std::size_t i = first; i < first + count; ++i, into += header_.slice_bytes()) {
      for (const DicomImage& frame : slices_[i]) put(frame, into);
    }
  }

 private:
  void put(const DicomImage& frame, std::byte* into) {
    const auto found = layers_.find(frame.segment);
    const std::size_t layer = found == layers_.end() ? 0 : found->second;
    const std::size_t width = bytes_of(header_.type);
    const auto components = static_cast<std::size_t>(header_.components);
    for_each_in_segment(frame, frames_.samples(frame), [&](std::size_t i, std::int64_t segment) {
      // Requires a little-endian host.
      std::memcpy(into + (i * components + layer) * width, &segment, width);
    });
  }

  FramesOfSlices slices_;
  Layers layers_;
  ImageHeader header_;
  DicomFrames frames_;
};

// Returns the distance of slices: the stated one, or else the least distance of frames.
double slice_step(const std::vector<DicomImage>& frames) {
  const DicomImage& first = frames.front();
  if (first.slice_spacing == SpacingSource::kBetweenSlices) return first.spacing[2];
  double least = 0;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const double gap = frames[i].along - frames[i - 1].along;
    if (gap > 1e-3 && (least == 0 || gap < least)) least = gap;
  }
  return least > 0 ? least : first.spacing[2];
}

// Returns the frames of each slice, sorted along the normal.
FramesOfSlices frames_of_slices(const fs::path& place, const std::vector<DicomImage>& frames,
                                double step) {
  const DicomImage& first = frames.front();
  FramesOfSlices slices;
  for (const DicomImage& frame : frames) {
    const double at = (frame.along - first.along) / step;
    const Vec3 expected =
        moved(first.position, frame.along - first.along, cross(first.row, first.column));
    const double turned = 2 - dot(frame.row, first.row) - dot(frame.column, first.column);
    const bool is_on_grid = std::abs(at - std::round(at)) <= kFrameOnGrid &&
                            at < double{kMaxSide} &&
                            length(difference(frame.position, expected)) <=
                                kFrameOnGrid * std::min(first.spacing[0], first.spacing[1]) &&
                            turned < 1e-4;
    if (!is_on_grid) {
      fail_reading(place,
                   "frame " + std::to_string(frame.frame + 1) +
                       " of its segmentation is not on a grid with slices " + rounded_text(step) +
                       " mm apart",
                   "Convert it to NIfTI or NRRD, for example with dcmqi or 3D Slicer");
    }
    const auto slice = static_cast<std::size_t>(std::lround(at));
    if (slice >= slices.size()) slices.resize(slice + 1);
    slices[slice].push_back(frame);
  }
  return slices;
}

}  // namespace

StoredVolume open_dicom_segmentation(const fs::path& place, std::vector<DicomImage> frames,
                                     const VolumeChoice& choice) {
  if (frames.front().file != frames.back().file) {
    fail_reading(place, "its series has several segmentations (DICOM SEG), each in a file",
                 "Give one of these files");
  }
  std::stable_sort(frames.begin(), frames.end(),
                   [](const DicomImage& a, const DicomImage& b) { return a.along < b.along; });
  const DicomImage first = frames.front();
  const double step = slice_step(frames);
  FramesOfSlices slices = frames_of_slices(place, frames, step);
  DicomFrames pixels;
  if (first.segmentation == Segmentation::kFractional) set_largest_shares(slices, pixels);
  const bool is_map = first.segmentation == Segmentation::kLabelMap;
  Layers layers = is_map ? Layers{{0, 0}} : separated_layers(slices, pixels);
  std::size_t layer_count = 1;
  for (const auto& [segment, layer] : layers) layer_count = std::max(layer_count, layer + 1);

  StoredVolume volume{.header = {.values = kNumbersAsStored}};
  volume.contents.labels = dicom_segments(first.file);
  for (SourceLabel& label : volume.contents.labels) {
    const auto found = layers.find(static_cast<std::int64_t>(label.stored));
    if (found != layers.end()) label.layer = static_cast<int>(found->second);
  }
  ImageHeader& header = volume.header;
  header.dims = {first.size[0], first.size[1], static_cast<std::int64_t>(slices.size())};
  const bool is_wide = is_map ? bytes_of(first.type) > 1 : layers.rbegin()->first > 255;
  header.type = is_wide ? StoredType::kU16 : StoredType::kU8;
  header.components = static_cast<std::int64_t>(layer_count);
  header.meaning = {.space = WorldSpace::kLps, .length_unit = "mm", .value_unit = {}};
  set_axes(header,
           {scaled(first.row, first.spacing[0]), scaled(first.column, first.spacing[1]),
            scaled(cross(first.row, first.column), step)},
           first.has_origin ? stated(first.position) : kNotStated);
  if (first.plane_spacing == SpacingSource::kNone) {
    header.geometry.spacing[0] = std::nullopt;
    header.geometry.spacing[1] = std::nullopt;
  }
  if (slices.size() == 1 && first.slice_spacing == SpacingSource::kNone) {
    header.geometry.spacing[2] = std::nullopt;
  }
  check_header(place, header);
  check_layers(place, volume.contents.labels, header.components, choice);
  if (first.segmentation == Segmentation::kFractional) {
    volume.notices.push_back("'" + place.string() +
                             "': its segments are fractional; a sample with half of a segment's "
                             "largest share or more is in it.");
  }
  volume.slices = std::make_unique<SegmentSlices>(std::move(slices), std::move(layers), header);
  return volume;
}

}  // namespace multitetra
