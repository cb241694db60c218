#include "server/dataset/streamed_volume.hpp"

#include <cassert>
#include <span>
#include <utility>
#include <variant>
#include <vector>

namespace multitetra {
namespace {

class PayloadSlices : public StoredSlices {
 public:
  PayloadSlices(PlainPayload payload, const ImageHeader& header)
      : reader_(std::move(payload)),
        width_(bytes_of(header.type)),
        slice_bytes_(static_cast<std::size_t>(header.dims[0] * header.dims[1]) * width_) {}

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    reader_.read(first * slice_bytes_, count * slice_bytes_, width_, into);
  }

 private:
  PayloadReader reader_;
  std::size_t width_;
  std::size_t slice_bytes_;
};

class StreamedVolume : public VolumeSource {
 public:
  StreamedVolume(std::filesystem::path file, const ImageHeader& header,
                 std::unique_ptr<StoredSlices> slices, Notice notice)
      : file_(std::move(file)),
        header_(volume_header(header)),
        stored_(header.type),
        slices_(std::move(slices)),
        notice_(std::move(notice)),
        searched_(static_cast<std::size_t>(header.dims[2])) {
    tell_conversion(notice_, file_, stored_);
  }

  [[nodiscard]] const VolumeHeader& header() const override { return header_; }

  void read(std::int32_t first_slice, std::int32_t slices, Samples& into) override {
    assert(first_slice >= 0 && slices >= 1 && first_slice <= header_.dims[2] - slices);
    const auto first = static_cast<std::size_t>(first_slice);
    const auto count = static_cast<std::size_t>(slices);
    resize(into, header_.type, count * header_.samples_per_slice());
    if (!is_converted(stored_)) slices_->read(first, count, bytes_of(into));
    if (header_.type != SampleType::kF32) return;
    const std::span<float> samples(std::get<std::vector<float>>(into));
    for (std::size_t i = 0; i < count; ++i) {
      finish_slice(first + i,
                   samples.subspan(i * header_.samples_per_slice(), header_.samples_per_slice()));
    }
  }

  [[nodiscard]] bool streams() const override { return true; }

 private:
  void finish_slice(std::size_t slice, std::span<float> samples) {
    if (is_converted(stored_)) {
      buffer_.resize(samples.size() * bytes_of(stored_));
      slices_->read(slice, 1, buffer_.data());
      convert(stored_, buffer_.data(), samples);
    }
    const std::uint64_t infinite = make_infinite_void(samples);
    if (searched_[slice]) return;
    searched_[slice] = true;
    infinite_ += infinite;
    if (++slices_searched_ == searched_.size()) tell_infinite(notice_, file_, infinite_);
  }

  std::filesystem::path file_;
  VolumeHeader header_;
  StoredType stored_;
  std::unique_ptr<StoredSlices> slices_;
  Notice notice_;
  std::vector<std::byte> buffer_;  // One slice before its conversion.
  std::vector<bool> searched_;     // The slices whose infinite samples are counted.
  std::size_t slices_searched_ = 0;
  std::uint64_t infinite_ = 0;
};

}  // namespace

std::unique_ptr<StoredSlices> slices_of(PlainPayload payload, const ImageHeader& header) {
  return std::make_unique<PayloadSlices>(std::move(payload), header);
}

VolumeHeader volume_header(const ImageHeader& image) {
  VolumeHeader header;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    header.dims[axis] = static_cast<std::int32_t>(image.dims[axis]);
  }
  header.type = type_in_memory(image.type);
  header.spacing = image.spacing;
  header.index_to_world = image.index_to_world;
  return header;
}

std::unique_ptr<VolumeSource> streamed_volume(std::filesystem::path file, const ImageHeader& header,
                                              std::unique_ptr<StoredSlices> slices, Notice notice) {
  return std::make_unique<StreamedVolume>(std::move(file), header, std::move(slices),
                                          std::move(notice));
}

}  // namespace multitetra
