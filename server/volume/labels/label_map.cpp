#include "server/volume/labels/label_map.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "common/base/scratch_file.hpp"

namespace multitetra {
namespace {

// Of the kernel; they add up to 2^4 along an axis, so to 2^12 along three.
constexpr std::array<std::uint32_t, 5> kWeights = {1, 4, 6, 4, 1};
constexpr std::int32_t kReach = 2;
constexpr std::int32_t kWhole = 1 << 12;
constexpr std::int32_t kSteps = 256;  // Of the field's values from 0 to 1.

// Beyond it not every whole number is an f32.
constexpr float kFarthestWhole = 16'777'216;

// The field where the kernel sees `sum` of kWhole inside of the label. Halves are rounded away from
// one half, so that the fields of two complementary indicators add up to 1.
float field_value(std::int32_t sum, bool is_inside) {
  const std::int32_t over = sum - kWhole / 2;
  const std::int32_t steps = (std::abs(over) * kSteps + kWhole / 2) / kWhole;
  const std::int32_t value = kSteps / 2 + (over < 0 ? -steps : steps);
  constexpr std::int32_t kHalf = kSteps / 2;
  const std::int32_t held = is_inside ? std::max(value, kHalf + 1) : std::min(value, kHalf - 1);
  return static_cast<float>(held) / static_cast<float>(kSteps);
}

// ---- which labels there are

class LabelCensus {
 public:
  LabelCensus(const std::filesystem::path& name, const VolumeHeader& header)
      : name_(name), header_(header) {}

  void add(const Samples& slab, std::int32_t first_slice) {
    std::visit(
        [&](const auto& samples) {
          const std::size_t slice = header_.samples_per_slice();
          for (std::size_t i = 0; i < samples.size();) {
            // Runs of one label are counted at once.
            const auto value = samples[i];
            const std::size_t end = (i / slice + 1) * slice;
            std::size_t next = i + 1;
            while (next < end && samples[next] == value) ++next;
            count(static_cast<float>(value), next - i, first_slice, i / slice, i % slice);
            i = next;
          }
        },
        slab);
  }

  [[nodiscard]] std::vector<FoundLabel> found() const {
    std::vector<FoundLabel> labels;
    for (const auto& [value, label] : labels_) labels.push_back(label);
    return labels;
  }

 private:
  void count(float value, std::size_t samples, std::int32_t first_slice, std::size_t slice,
             std::size_t place) {
    if (value == 0 || std::isnan(value)) return;
    const std::int32_t z = first_slice + static_cast<std::int32_t>(slice);
    if (last_ == nullptr || last_->value != static_cast<double>(value)) {
      require_label(value, place, z);
      const auto [at, is_new] = labels_.try_emplace(
          value, FoundLabel{.value = static_cast<double>(value), .first_slice = z});
      last_ = &at->second;
      if (is_new && labels_.size() > kMostFoundLabels) {
        fail_reading(name_,
                     "it has more than " + std::to_string(kMostFoundLabels) + " different values",
                     "Labels are for segmentations; prepare it without them");
      }
    }
    last_->samples += samples;
    last_->last_slice = std::max(last_->last_slice, z);
  }

  void require_label(float value, std::size_t place, std::int32_t z) const {
    if (std::trunc(value) == value && std::abs(value) <= kFarthestWhole) return;
    const auto side = static_cast<std::size_t>(header_.dims[0]);
    const std::string where = std::to_string(place % side) + ", " + std::to_string(place / side) +
                              ", " + std::to_string(z);
    fail_reading(name_,
                 "its sample at " + where + " is " + std::to_string(value) +
                     ", which is no whole number of at most 2^24",
                 "Labels are for segmentations; prepare it without them");
  }

  const std::filesystem::path& name_;
  const VolumeHeader& header_;
  std::map<float, FoundLabel> labels_;
  FoundLabel* last_ = nullptr;  // That was counted last.
};

std::span<const std::byte> bytes_of_all(const Samples& samples) {
  return std::visit([](const auto& values) { return std::as_bytes(std::span(values)); }, samples);
}

}  // namespace

struct LabelMap::Content {
  VolumeHeader header;
  ScratchFile scratch;
  std::vector<FoundLabel> labels;

  explicit Content(VolumeHeader map, const std::filesystem::path& folder)
      : header(std::move(map)), scratch(folder) {}

  [[nodiscard]] std::size_t slice_bytes() const {
    return header.samples_per_slice() * static_cast<std::size_t>(bytes_per_sample(header.type));
  }
};

namespace {

// ---- the field of one

// A slice of the indicator, and smoothed along x and y.
struct SmoothSlice {
  std::vector<std::uint8_t> inside;
  std::vector<std::uint16_t> sums;  // At most 2^8.
};

// What lies `step` away from `at`, of `side` samples; the last ones go on.
std::size_t held_within(std::int32_t at, std::int32_t step, std::int32_t side) {
  return static_cast<std::size_t>(std::clamp(at + step, 0, side - 1));
}

// Smoothes along x, then along y.
void smooth(const std::array<std::int32_t, 3>& dims, SmoothSlice& slice) {
  const auto width = static_cast<std::size_t>(dims[0]);
  std::vector<std::uint16_t> rows(slice.inside.size());
  for (std::size_t y = 0; y < static_cast<std::size_t>(dims[1]); ++y) {
    const std::uint8_t* const from = slice.inside.data() + y * width;
    for (std::int32_t x = 0; x < dims[0]; ++x) {
      std::uint32_t sum = 0;
      for (std::int32_t k = -kReach; k <= kReach; ++k) {
        sum += kWeights[static_cast<std::size_t>(k + kReach)] * from[held_within(x, k, dims[0])];
      }
      rows[y * width + static_cast<std::size_t>(x)] = static_cast<std::uint16_t>(sum);
    }
  }
  slice.sums.resize(slice.inside.size());
  for (std::int32_t y = 0; y < dims[1]; ++y) {
    std::array<const std::uint16_t*, kWeights.size()> from{};
    for (std::int32_t k = -kReach; k <= kReach; ++k) {
      from[static_cast<std::size_t>(k + kReach)] =
          rows.data() + held_within(y, k, dims[1]) * width;
    }
    std::uint16_t* const into = slice.sums.data() + static_cast<std::size_t>(y) * width;
    for (std::size_t x = 0; x < width; ++x) {
      std::uint32_t sum = 0;
      for (std::size_t k = 0; k < kWeights.size(); ++k) sum += kWeights[k] * from[k][x];
      into[x] = static_cast<std::uint16_t>(sum);
    }
  }
}

}  // namespace

class LabelMap::Field : public VolumeSource {
 public:
  Field(std::shared_ptr<const Content> map, double value, std::int32_t first_slice,
             std::int32_t last_slice)
      : map_(std::move(map)),
        header_(map_->header),
        value_(value),
        first_(first_slice),
        last_(last_slice) {
    header_.type = SampleType::kF32;
    header_.meaning.value_unit.clear();
    resize_for(map_->header.type);
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
      if (z < first_ - kReach || z > last_ + kReach) continue;  // The label is out of reach.
      make_slice(z, std::span(values).subspan(static_cast<std::size_t>(i) * slice, slice));
    }
  }

 private:
  void resize_for(SampleType type) {
    constexpr std::array<Samples (*)(), 5> kMake = {
        [] { return Samples(std::vector<std::uint8_t>()); },
        [] { return Samples(std::vector<std::int8_t>()); },
        [] { return Samples(std::vector<std::uint16_t>()); },
        [] { return Samples(std::vector<std::int16_t>()); },
        [] { return Samples(std::vector<float>()); }};
    stored_ = kMake[static_cast<std::size_t>(type)]();
    std::visit([&](auto& samples) { samples.resize(header_.samples_per_slice()); }, stored_);
  }

  void make_slice(std::int32_t z, std::span<float> into) {
    std::array<const SmoothSlice*, kWeights.size()> from{};
    for (std::int32_t k = -kReach; k <= kReach; ++k) {
      from[static_cast<std::size_t>(k + kReach)] =
          &smooth_slice(static_cast<std::int32_t>(held_within(z, k, header_.dims[2])));
    }
    const std::vector<std::uint8_t>& inside = from[kReach]->inside;
    for (std::size_t i = 0; i < into.size(); ++i) {
      std::uint32_t sum = 0;
      for (std::size_t k = 0; k < kWeights.size(); ++k) sum += kWeights[k] * from[k]->sums[i];
      into[i] = field_value(static_cast<std::int32_t>(sum), inside[i] != 0);
    }
  }

  // The last kWeights.size() slices stay, and any so many that follow each other have places of
  // their own among them.
  const SmoothSlice& smooth_slice(std::int32_t z) {
    const std::size_t place = static_cast<std::size_t>(z) % kWeights.size();
    SmoothSlice& slice = kept_[place];
    if (kept_z_[place] == z) return slice;
    const std::uint64_t bytes = map_->slice_bytes();
    std::visit(
        [&](auto& samples) {
          map_->scratch.get(static_cast<std::uint64_t>(z) * bytes,
                            std::as_writable_bytes(std::span(samples)));
          slice.inside.resize(samples.size());
          std::transform(samples.begin(), samples.end(), slice.inside.begin(), [&](auto sample) {
            return static_cast<std::uint8_t>(static_cast<double>(sample) == value_);
          });
        },
        stored_);
    smooth(header_.dims, slice);
    kept_z_[place] = z;
    return slice;
  }

  std::shared_ptr<const Content> map_;
  VolumeHeader header_;
  double value_;
  std::int32_t first_;
  std::int32_t last_;
  Samples stored_;  // A slice of the map.
  std::array<SmoothSlice, kWeights.size()> kept_;
  std::array<std::int32_t, kWeights.size()> kept_z_ = {-1, -1, -1, -1, -1};
};

LabelMap::LabelMap(const std::filesystem::path& name, VolumeSource& source,
                   const std::filesystem::path& scratch_folder) {
  const auto content = std::make_shared<Content>(source.header(), scratch_folder);
  const VolumeHeader& header = content->header;
  constexpr std::size_t kSlabBytes = std::size_t{64} << 20;
  const auto most = static_cast<std::int32_t>(
      std::clamp<std::size_t>(kSlabBytes / content->slice_bytes(), 1, 1024));
  LabelCensus census(name, header);
  Samples slab;
  for (std::int32_t z = 0; z < header.dims[2]; z += most) {
    source.read(z, std::min(most, header.dims[2] - z), slab);
    census.add(slab, z);
    (void)content->scratch.put(bytes_of_all(slab));
  }
  content->labels = census.found();
  content_ = content;
}

std::span<const FoundLabel> LabelMap::labels() const { return content_->labels; }

std::unique_ptr<VolumeSource> LabelMap::field(double value) const {
  const auto found = std::lower_bound(
      content_->labels.begin(), content_->labels.end(), value,
      [](const FoundLabel& label, double wanted) { return label.value < wanted; });
  const bool is_there = found != content_->labels.end() && found->value == value;
  const std::int32_t slices = content_->header.dims[2];
  // The background may be anywhere; a label that does not occur is nowhere.
  const std::int32_t first = is_there ? found->first_slice : value == 0 ? 0 : slices + kReach + 1;
  const std::int32_t last = is_there ? found->last_slice : value == 0 ? slices - 1 : -kReach - 1;
  return std::make_unique<Field>(content_, value, first, last);
}

}  // namespace multitetra
