#include "server/dataset/box_of_volume.hpp"

#include <algorithm>
#include <cassert>
#include <utility>
#include <variant>

#include "common/base/scratch_file.hpp"
#include "server/dataset/detail/brick_layers.hpp"
#include "server/dataset/detail/prepared_sinks.hpp"

namespace multitetra {
namespace {

GridCounts counts_of(GridPoint extent) { return {extent.x, extent.y, extent.z}; }

// Copies the columns from `begin` to `end` of `slices` slices.
void crop(const Samples& slab, const VolumeHeader& header, std::int32_t slices, GridPoint begin,
          GridPoint end, Samples& into) {
  std::visit(
      [&](const auto& from) {
        using Values = std::decay_t<decltype(from)>;
        if (!std::holds_alternative<Values>(into)) into = Values();
        auto& cropped = std::get<Values>(into);
        cropped.clear();
        for (std::int32_t z = 0; z < slices; ++z) {
          for (std::int32_t y = begin.y; y < end.y; ++y) {
            const auto row = from.begin() + std::ptrdiff_t{header.dims[0]} *
                                                (y + std::ptrdiff_t{header.dims[1]} * z);
            cropped.insert(cropped.end(), row + begin.x, row + end.x);
          }
        }
      },
      slab);
}

}  // namespace

// Stores bricks of samples one after another in an unnamed temporary file.
class BoxOfVolume::Sink : public PreparedSink {
 public:
  Sink(std::filesystem::path folder, const GridCounts& dims, SampleType type)
      : folder_(std::move(folder)),
        file_(folder_),
        layout_(dims),
        width_(static_cast<std::uint64_t>(bytes_per_sample(type))) {}

  void add_samples(std::span<const std::byte> bytes) override { (void)file_.put(bytes); }
  void read_samples(std::size_t first, std::span<std::byte> bytes) const override {
    file_.get(width_ * layout_.offset(layout_.at(first)), bytes);
  }
  [[nodiscard]] std::unique_ptr<Scratch> new_scratch() const override {
    return std::make_unique<ScratchFile>(folder_);
  }
  void add_spectrum_brick(std::size_t, std::span<const std::byte>) override { assert(false); }

 private:
  std::filesystem::path folder_;
  ScratchFile file_;
  BrickLayout layout_;
  std::uint64_t width_;
};

BoxOfVolume::BoxOfVolume(VolumeSource& source, GridPoint begin, GridPoint end,
                         const Options& options)
    : begin_(begin) {
  const VolumeHeader& whole = source.header();
  VolumeHeader box = whole;
  box.dims = counts_of(end - begin);
  sink_ = std::make_unique<Sink>(options.folder, box.dims, box.type);
  samples_ = std::make_unique<BrickedSamples>(
      box.dims, box.type,
      [this](std::size_t first, std::span<std::byte> bytes) { sink_->read_samples(first, bytes); });

  BrickLayers layers(box, *sink_);
  const std::uint64_t slice_bytes =
      whole.samples_per_slice() * static_cast<std::uint64_t>(bytes_per_sample(whole.type));
  std::int32_t most = BrickLayers::kSlices;
  while (most > 1 && static_cast<std::uint64_t>(most) * slice_bytes > options.slab_bytes) most /= 2;
  Samples slab;
  Samples cropped;
  for (std::int32_t z = begin.z; z < end.z; z += most) {
    const std::int32_t slices = std::min(most, end.z - z);
    source.read(z, slices, slab);
    crop(slab, whole, slices, begin, end, cropped);
    layers.add(cropped, slices);
    if (options.progress) {
      options.progress(box.samples_per_slice() * static_cast<std::uint64_t>(z + slices - begin.z),
                       box.samples_per_slice() * static_cast<std::uint64_t>(end.z - begin.z));
    }
  }
}

BoxOfVolume::~BoxOfVolume() = default;

void BoxOfVolume::read(GridPoint first, GridPoint extent, Samples& into) const {
  samples_->read(first - begin_, extent, into);
}

}  // namespace multitetra
