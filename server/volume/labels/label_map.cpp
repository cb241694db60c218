#include "server/volume/labels/label_map.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "common/base/in_parallel.hpp"
#include "common/base/number_text.hpp"
#include "common/base/scratch_file.hpp"
#include "server/volume/labels/border_samples.hpp"
#include "server/volume/labels/label_borders.hpp"
#include "server/volume/labels/label_smoothing.hpp"
#include "server/volume/labels/thin_parts.hpp"

namespace multitetra {
namespace {

// Wider integers are rounded to f32. Those from here on may have been other labels.
constexpr float kFirstInexactInteger = 16'777'216;

// ---- finding the labels

class LabelCensus {
 public:
  LabelCensus(const std::filesystem::path& name, const VolumeHeader& header)
      : name_(name), header_(header) {}

  void add(const Samples& slab, std::int32_t first_slice) {
    std::visit(
        [&](const auto& samples) {
          const auto width = static_cast<std::size_t>(header_.dims[0]);
          const auto rows = static_cast<std::size_t>(header_.dims[1]);
          for (std::size_t i = 0; i < samples.size();) {
            // Counts runs of one label at once.
            const auto value = samples[i];
            const std::size_t row = i / width;
            const std::size_t end = (row + 1) * width;
            std::size_t next = i + 1;
            while (next < end && samples[next] == value) ++next;
            count(static_cast<float>(value), next - i,
                  {static_cast<std::int32_t>(i % width), static_cast<std::int32_t>(row % rows),
                   first_slice + static_cast<std::int32_t>(row / rows)});
            i = next;
          }
        },
        slab);
  }

  [[nodiscard]] std::vector<LabelSummary> found() const {
    std::vector<LabelSummary> labels;
    for (const auto& [value, label] : labels_) {
      labels.push_back(label);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        // Rounding may move the mean out of the box.
        labels.back().centroid[axis] =
            std::clamp<double>(label.centroid[axis] / static_cast<double>(label.samples),
                               label.least[axis], label.greatest[axis]);
      }
    }
    return labels;
  }

 private:
  // Counts a run of samples in a row that begins at `place`.
  void count(float value, std::size_t samples, const std::array<std::int32_t, 3>& place) {
    if (value == 0 || std::isnan(value)) return;
    if (last_ == nullptr || last_->value != static_cast<double>(value)) {
      require_label(value, place);
      const auto [at, is_new] = labels_.try_emplace(
          value,
          LabelSummary{.value = static_cast<double>(value), .least = place, .greatest = place});
      last_ = &at->second;
      if (is_new && labels_.size() > kMaxLabels) {
        fail_reading(name_, "it has more than " + std::to_string(kMaxLabels) + " different values",
                     "Labels are for segmentations; prepare it without label options");
      }
    }
    last_->samples += samples;
    std::array<std::int32_t, 3> end = place;
    end[0] += static_cast<std::int32_t>(samples) - 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      last_->least[axis] = std::min(last_->least[axis], place[axis]);
      last_->greatest[axis] = std::max(last_->greatest[axis], end[axis]);
      // Sums; found() divides them.
      last_->centroid[axis] +=
          static_cast<double>(samples) * (static_cast<double>(place[axis]) + end[axis]) / 2;
    }
  }

  void require_label(float value, const std::array<std::int32_t, 3>& place) const {
    const bool is_integer = std::trunc(value) == value;
    if (is_integer && std::abs(value) < kFirstInexactInteger) return;
    const std::string where = std::to_string(place[0]) + ", " + std::to_string(place[1]) + ", " +
                              std::to_string(place[2]);
    if (is_integer) {
      fail_reading(name_,
                   "its sample at " + where +
                       " has a label of 2^24 or more, which cannot be told from its neighbors",
                   "Renumber the labels from 1, as with skimage.segmentation.relabel_sequential or "
                   "fastremap.renumber, and prepare the result");
    }
    fail_reading(name_,
                 "its sample at " + where + " is " + shortest_text(double{value}) +
                     ", which is not an integer",
                 "Labels are for segmentations; prepare it without label options");
  }

  const std::filesystem::path& name_;
  const VolumeHeader& header_;
  std::map<float, LabelSummary> labels_;
  LabelSummary* last_ = nullptr;  // The last label counted.
};

std::span<const std::byte> bytes_of_all(const Samples& samples) {
  return std::visit([](const auto& values) { return std::as_bytes(std::span(values)); }, samples);
}

}  // namespace

// A label map in a file. Copies of slices in the type of the samples are made in `stored`, which
// belongs to the caller.
struct LabelMap::Content {
  VolumeHeader header;
  std::int32_t layers;  // Of samples beyond the map that `borders` has around it.
  ScratchFile scratch;
  std::vector<LabelSummary> labels;
  std::optional<LabelBorders> borders;

  Content(const VolumeHeader& map, LabelEnds ends, const std::filesystem::path& folder)
      : header(map), layers(ends == LabelEnds::kClosed ? 1 : 0), scratch(folder) {}

  [[nodiscard]] std::size_t slice_bytes() const {
    return header.samples_per_slice() * static_cast<std::size_t>(bytes_per_sample(header.type));
  }
  [[nodiscard]] Samples empty_slice() const {
    constexpr std::array<Samples (*)(), 5> kMake = {
        [] { return Samples(std::vector<std::uint8_t>()); },
        [] { return Samples(std::vector<std::int8_t>()); },
        [] { return Samples(std::vector<std::uint16_t>()); },
        [] { return Samples(std::vector<std::int16_t>()); },
        [] { return Samples(std::vector<float>()); }};
    Samples slice = kMake[static_cast<std::size_t>(header.type)]();
    std::visit([&](auto& samples) { samples.resize(header.samples_per_slice()); }, slice);
    return slice;
  }
  [[nodiscard]] LabelDims dims_with_layers() const {
    LabelDims dims = header.dims;
    for (std::int32_t& side : dims) side += 2 * layers;
    return dims;
  }
  void read(std::int32_t z, std::span<std::int32_t> into, Samples& stored) const {
    std::visit(
        [&](auto& samples) {
          scratch.get(static_cast<std::uint64_t>(z) * slice_bytes(),
                      std::as_writable_bytes(std::span(samples)));
          std::transform(samples.begin(), samples.end(), into.begin(), [](auto sample) {
            if constexpr (std::is_same_v<decltype(sample), float>) {
              if (std::isnan(sample)) return kVoidLabel;
            }
            return static_cast<std::int32_t>(sample);
          });
        },
        stored);
  }
  // The same with the layers.
  void read_with_layers(std::int32_t z, std::span<std::int32_t> into, std::span<std::int32_t> slice,
                        Samples& stored) const {
    std::fill(into.begin(), into.end(), kBeyondMap);
    if (z < layers || z >= header.dims[2] + layers) return;
    read(z - layers, slice, stored);
    const auto width = static_cast<std::size_t>(header.dims[0]);
    for (std::size_t row = 0; row < static_cast<std::size_t>(header.dims[1]); ++row) {
      std::copy_n(slice.begin() + static_cast<std::ptrdiff_t>(row * width), width,
                  into.begin() + static_cast<std::ptrdiff_t>(border_place(0, row)));
    }
  }
  // Returns the place of sample x, y in a slice with the layers.
  [[nodiscard]] std::size_t border_place(std::size_t x, std::size_t y) const {
    const auto all = static_cast<std::size_t>(layers);
    return x + all + (y + all) * (static_cast<std::size_t>(header.dims[0]) + 2 * all);
  }
};

namespace {

// ---- the field of a label

// A slice of the indicator, also smoothed along x and y.
struct SmoothSlice {
  std::int32_t z = -1;
  std::vector<std::uint8_t> inside;
  std::vector<std::uint8_t> near;   // Inside, or next to it within the slice.
  std::vector<std::uint16_t> sums;  // At most 2^8.
};

// Smooths along x, then along y, within the box; the indicator is 0 outside.
void smooth(const std::array<std::int32_t, 3>& dims, const SampleBox& box, SmoothSlice& slice) {
  const auto width = static_cast<std::size_t>(dims[0]);
  std::vector<std::uint16_t> rows(slice.inside.size());
  std::vector<std::uint8_t> near_rows(slice.inside.size());
  for (std::int32_t row = box.least[1]; row <= box.greatest[1]; ++row) {
    const std::size_t y = static_cast<std::size_t>(row);
    const std::uint8_t* const from = slice.inside.data() + y * width;
    for (std::int32_t x = box.least[0]; x <= box.greatest[0]; ++x) {
      std::uint32_t sum = 0;
      for (std::int32_t k = -kSmoothingReach; k <= kSmoothingReach; ++k) {
        sum += smoothing_weight(k) * from[clamped_step(x, k, dims[0])];
      }
      const std::size_t at = y * width + static_cast<std::size_t>(x);
      rows[at] = static_cast<std::uint16_t>(sum);
      near_rows[at] = static_cast<std::uint8_t>(from[clamped_step(x, -1, dims[0])] | from[x] |
                                                from[clamped_step(x, 1, dims[0])]);
    }
  }
  slice.sums.resize(slice.inside.size());
  slice.near.resize(slice.inside.size());
  for (std::int32_t y = box.least[1]; y <= box.greatest[1]; ++y) {
    const std::size_t to = static_cast<std::size_t>(y) * width;
    const std::size_t below = clamped_step(y, -1, dims[1]) * width;
    const std::size_t above = clamped_step(y, 1, dims[1]) * width;
    for (auto x = static_cast<std::size_t>(box.least[0]);
         x <= static_cast<std::size_t>(box.greatest[0]); ++x) {
      std::uint32_t sum = 0;
      for (std::int32_t k = -kSmoothingReach; k <= kSmoothingReach; ++k) {
        sum += smoothing_weight(k) * rows[clamped_step(y, k, dims[1]) * width + x];
      }
      slice.sums[to + x] = static_cast<std::uint16_t>(sum);
      slice.near[to + x] = static_cast<std::uint8_t>(near_rows[below + x] | near_rows[to + x] |
                                                     near_rows[above + x]);
    }
  }
}

// Returns the box outside of which the field of a label is 0, in a map of `dims` samples.
SampleBox field_box(const LabelSummary& label, const std::array<std::int32_t, 3>& dims) {
  SampleBox box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.least[axis] = std::max(0, label.least[axis] - kSmoothingReach);
    box.greatest[axis] = std::min(dims[axis] - 1, label.greatest[axis] + kSmoothingReach);
  }
  return box;
}

}  // namespace

class LabelMap::Field : public VolumeSource {
 public:
  // The field is 0 outside of `box`, or everywhere if it is absent.
  Field(std::shared_ptr<const Content> map, std::int32_t label, std::optional<SampleBox> box)
      : map_(std::move(map)),
        header_(map_->header),
        label_(label),
        box_(box),
        stored_(map_->empty_slice()),
        labels_(header_.samples_per_slice()),
        borders_(slice_samples(map_->dims_with_layers())) {
    header_.type = SampleType::kF32;
    header_.meaning.value_unit.clear();
  }

  [[nodiscard]] const VolumeHeader& header() const override { return header_; }

  void read(std::int32_t first_slice, std::int32_t slices, Samples& into) override {
    assert(first_slice >= 0 && slices >= 1 && first_slice <= header_.dims[2] - slices);
    const std::size_t slice = header_.samples_per_slice();
    if (!std::holds_alternative<std::vector<float>>(into)) into = std::vector<float>();
    auto& values = std::get<std::vector<float>>(into);
    values.assign(static_cast<std::size_t>(slices) * slice, 0.0F);
    for (std::int32_t i = 0; i < slices; ++i) {
      const std::int32_t z = first_slice + i;
      if (!box_ || z < box_->least[2] || z > box_->greatest[2]) continue;
      make_slice(z, std::span(values).subspan(static_cast<std::size_t>(i) * slice, slice));
    }
  }

 private:
  static constexpr std::size_t kSlices = 2 * kSmoothingReach + 1;

  void make_slice(std::int32_t z, std::span<float> into) {
    std::array<const SmoothSlice*, kSlices> from{};
    for (std::int32_t k = -kSmoothingReach; k <= kSmoothingReach; ++k) {
      from[static_cast<std::size_t>(k + kSmoothingReach)] =
          &smooth_slice(static_cast<std::int32_t>(clamped_step(z, k, header_.dims[2])));
    }
    map_->borders->get(z + map_->layers, borders_);
    const SmoothSlice& here = *from[kSmoothingReach];
    const SmoothSlice& below = *from[kSmoothingReach - 1];
    const SmoothSlice& above = *from[kSmoothingReach + 1];
    constexpr int kHalf = kFieldSteps / 2;
    const auto make_sample = [&](std::size_t i, int magnitude) {
      std::uint32_t sum = 0;
      for (std::size_t k = 0; k < kSlices; ++k) {
        sum += smoothing_weight(static_cast<std::int32_t>(k) - kSmoothingReach) * from[k]->sums[i];
      }
      const bool is_inside = here.inside[i] != 0;
      const bool is_beside = (below.near[i] | here.near[i] | above.near[i]) != 0;
      int steps = smoothed_steps(sum);
      if (magnitude != 0 && is_beside) {
        steps = is_inside ? kHalf + magnitude : kHalf - magnitude;
      } else {
        steps = is_inside ? std::max(steps, kHalf + kMinMagnitude)
                          : std::min(steps, kHalf - kMinMagnitude);
      }
      into[i] = static_cast<float>(steps) / static_cast<float>(kFieldSteps);
    };
    const auto width = static_cast<std::size_t>(header_.dims[0]);
    const auto first = static_cast<std::size_t>(box_->least[0]);
    const auto last = static_cast<std::size_t>(box_->greatest[0]);
    for (std::int32_t y = box_->least[1]; y <= box_->greatest[1]; ++y) {
      const auto row = static_cast<std::size_t>(y);
      for (std::size_t x = first; x <= last; ++x) {
        make_sample(row * width + x, borders_[map_->border_place(x, row)].magnitude);
      }
    }
  }

  // Keeps kSlices slices; any kSlices consecutive ones can be kept together.
  const SmoothSlice& smooth_slice(std::int32_t z) {
    SmoothSlice& slice = kept_[static_cast<std::size_t>(z) % kSlices];
    if (slice.z == z) return slice;
    map_->read(z, labels_, stored_);
    slice.inside.resize(labels_.size());
    std::transform(labels_.begin(), labels_.end(), slice.inside.begin(), [&](std::int32_t label) {
      return static_cast<std::uint8_t>(label == label_ ? 1 : 0);
    });
    smooth(header_.dims, *box_, slice);
    slice.z = z;
    return slice;
  }

  std::shared_ptr<const Content> map_;
  VolumeHeader header_;
  std::int32_t label_;
  std::optional<SampleBox> box_;
  Samples stored_;
  std::vector<std::int32_t> labels_;
  std::vector<BorderSample> borders_;
  std::array<SmoothSlice, kSlices> kept_;
};

bool meets_end(const LabelSummary& label, const std::array<std::int32_t, 3>& dims) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (label.least[axis] == 0 || label.greatest[axis] == dims[axis] - 1) return true;
  }
  return false;
}

LabelMap::LabelMap(const std::filesystem::path& name, VolumeSource& source,
                   const std::filesystem::path& scratch_folder, LabelEnds ends,
                   const std::stop_token& stop) {
  const auto content = std::make_shared<Content>(source.header(), ends, scratch_folder);
  const VolumeHeader& header = content->header;
  constexpr std::size_t kSlabBytes = std::size_t{64} << 20;
  const auto most = static_cast<std::int32_t>(
      std::clamp<std::size_t>(kSlabBytes / content->slice_bytes(), 1, 1024));
  LabelCensus census(name, header);
  Samples slab;
  for (std::int32_t z = 0; z < header.dims[2]; z += most) {
    throw_if_stopped(stop);
    source.read(z, std::min(most, header.dims[2] - z), slab);
    census.add(slab, z);
    (void)content->scratch.put(bytes_of_all(slab));
  }
  content->labels = census.found();
  Samples stored = content->empty_slice();
  const auto read = [&](std::int32_t z, std::span<std::int32_t> into) {
    content->read(z, into, stored);
  };
  std::vector<std::int32_t> slice(header.samples_per_slice());
  content->borders.emplace(
      content->dims_with_layers(),
      [&](std::int32_t z, std::span<std::int32_t> into) {
        throw_if_stopped(stop);
        content->read_with_layers(z, into, slice, stored);
      },
      scratch_folder);
  const std::map<std::int32_t, std::uint64_t> thin = thin_samples(header.dims, read);
  const std::map<std::int32_t, double>& shortfalls = content->borders->shortfalls();
  for (LabelSummary& label : content->labels) {
    const auto shortfall = shortfalls.find(static_cast<std::int32_t>(label.value));
    label.surface_samples = static_cast<double>(label.samples) -
                            (shortfall == shortfalls.end() ? 0 : shortfall->second);
    const auto in_thin_parts = thin.find(static_cast<std::int32_t>(label.value));
    label.thin_samples = in_thin_parts == thin.end() ? 0 : in_thin_parts->second;
  }
  content_ = content;
}

std::span<const LabelSummary> LabelMap::labels() const { return content_->labels; }

std::unique_ptr<VolumeSource> LabelMap::field(double value) const {
  const auto found = std::lower_bound(
      content_->labels.begin(), content_->labels.end(), value,
      [](const LabelSummary& label, double wanted) { return label.value < wanted; });
  const bool is_there = found != content_->labels.end() && found->value == value;
  const auto& dims = content_->header.dims;
  if (is_there) {
    return std::make_unique<Field>(content_, static_cast<std::int32_t>(value),
                                   field_box(*found, dims));
  }
  // The background may be anywhere; labels that do not occur have no samples.
  const SampleBox everywhere = {.least = {}, .greatest = {dims[0] - 1, dims[1] - 1, dims[2] - 1}};
  return std::make_unique<Field>(content_, 0,
                                 value == 0 ? std::optional(everywhere) : std::nullopt);
}

}  // namespace multitetra
