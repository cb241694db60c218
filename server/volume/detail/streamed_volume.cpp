#include "server/volume/detail/streamed_volume.hpp"

#include <cassert>
#include <cstddef>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "server/volume/placement.hpp"

namespace multitetra {
namespace {

class StreamedVolume : public VolumeSource {
 public:
  StreamedVolume(std::filesystem::path file, StoredVolume stored, ComponentChoice component,
                 AllowedLoss loss, Notice notice)
      : file_(std::move(file)),
        conversion_(file_, stored.header, component),
        loss_(loss),
        header_(settled(stored.header)),
        stored_slice_bytes_(stored.header.slice_bytes()),
        slices_(std::move(stored.slices)),
        notice_(std::move(notice)),
        contents_(std::move(stored.contents)),
        searched_(static_cast<std::size_t>(header_.dims[2])) {
    header_.type = conversion_.type();
    if (!notice_) return;
    for (const std::string& text : stored.notices) notice_(text);
    for (const std::string& text : fact_notices(file_, stored.header)) notice_(text);
  }

  [[nodiscard]] const VolumeHeader& header() const override { return header_; }

  void read(std::int32_t first_slice, std::int32_t slices, Samples& into) override {
    assert(first_slice >= 0 && slices >= 1 && first_slice <= header_.dims[2] - slices);
    const auto first = static_cast<std::size_t>(first_slice);
    const auto count = static_cast<std::size_t>(slices);
    const std::size_t slice = header_.samples_per_slice();
    resize(into, header_.type, count * slice);
    if (conversion_.is_none()) slices_->read(first, count, bytes_of(into));
    for (std::size_t i = 0; i < count; ++i) {
      if (!conversion_.is_none()) {
        buffer_.resize(stored_slice_bytes_);
        slices_->read(first + i, 1, buffer_.data());
        conversion_.convert(buffer_.data(), slice, into, i * slice);
      }
      std::uint64_t infinite = 0;
      if (auto* const floats = std::get_if<std::vector<float>>(&into)) {
        infinite = make_infinite_void(std::span(*floats).subspan(i * slice, slice));
      }
      note_searched(first + i, infinite);
    }
  }

  [[nodiscard]] std::string rounding() const override { return conversion_.rounding(); }
  [[nodiscard]] const VolumeContents& contents() const override { return contents_; }

 private:
  void note_searched(std::size_t slice, std::uint64_t infinite) {
    if (searched_[slice]) return;
    searched_[slice] = true;
    infinite_ += infinite;
    if (++slices_searched_ < searched_.size()) return;
    if (loss_ != AllowedLoss::kAny) conversion_.require_small_loss();
    conversion_.report(notice_);
    for (const std::string& finding : slices_->findings()) {
      if (notice_) notice_(finding);
    }
    report_infinite(notice_, file_, infinite_);
  }

  std::filesystem::path file_;
  SampleConversion conversion_;
  AllowedLoss loss_;
  VolumeHeader header_;
  std::size_t stored_slice_bytes_;
  std::unique_ptr<StoredSlices> slices_;
  Notice notice_;
  VolumeContents contents_;
  std::vector<std::byte> buffer_;  // A slice before conversion.
  std::vector<bool> searched_;     // Slices whose infinite samples were counted.
  std::size_t slices_searched_ = 0;
  std::uint64_t infinite_ = 0;
};

}  // namespace

std::unique_ptr<VolumeSource> streamed_volume(std::filesystem::path file, StoredVolume stored,
                                              ComponentChoice component, AllowedLoss loss,
                                              Notice notice) {
  return std::make_unique<StreamedVolume>(std::move(file), std::move(stored), component, loss,
                                          std::move(notice));
}

}  // namespace multitetra
