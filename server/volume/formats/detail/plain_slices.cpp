#include "server/volume/formats/detail/plain_slices.hpp"

#include <algorithm>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "common/base/number_text.hpp"
#include "server/volume/formats/detail/input_file.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

// A part that is being read.
class OpenPart {
 public:
  OpenPart(const SamplePart& part, std::uint64_t part_bytes)
      : part_(part), part_bytes_(part_bytes), file_(part.file) {}

  // Throws if it is known that the part has fewer than `needed` bytes.
  void check(std::uint64_t needed) {
    if (part_.packing != Packing::kNone) {
      if (part_.packing == Packing::kHex ||
          UnpackedStream::packing_at(file_, part_.offset) != Packing::kNone) {
        return;
      }
      fail_damaged(part_.file, "its samples are not a gzip, zlib or bzip2 stream");
    }
    const std::uint64_t found = file_.size() < part_.offset ? 0 : file_.size() - part_.offset;
    if (found >= needed) {
      behind_ = found - std::min(found, part_bytes_);
      return;
    }
    fail_incomplete(part_.file, "it ends too early or is damaged; its header declares " +
                                    std::to_string(needed) + " bytes of samples, but it has " +
                                    std::to_string(found) + " bytes");
  }

  void read(std::uint64_t offset, std::span<std::byte> into) {
    if (part_.packing == Packing::kNone) return file_.read(part_.offset + offset, into);
    const std::uint64_t wanted = part_.skipped + offset;
    if (!stream_ || wanted < at_) {
      stream_.emplace(file_, part_.offset, packing());
      at_ = 0;
    }
    std::vector<std::byte> skipped(std::min<std::uint64_t>(wanted - at_, std::uint64_t{1} << 20));
    while (at_ < wanted) {
      take(std::span(skipped).first(std::min<std::uint64_t>(wanted - at_, skipped.size())));
    }
    take(into);
    if (at_ == part_.skipped + part_bytes_) require_end();
  }

  // Returns the bytes behind the part, as far as they are known.
  [[nodiscard]] std::uint64_t behind() const { return behind_; }
  [[nodiscard]] const fs::path& file() const { return part_.file; }

 private:
  [[nodiscard]] Packing packing() const {
    return part_.packing == Packing::kHex ? part_.packing
                                          : UnpackedStream::packing_at(file_, part_.offset);
  }

  void take(std::span<std::byte> bytes) {
    const std::size_t count = stream_->read_some(bytes);
    at_ += count;
    if (count == bytes.size()) return;
    fail_incomplete(part_.file, "its compressed samples end after " + std::to_string(at_) + " of " +
                                    std::to_string(part_.skipped + part_bytes_) + " bytes");
  }

  // Called after the last sample: other times may follow, but only the end of a stream proves that
  // its bytes are intact.
  void require_end() {
    behind_ = stream_->require_good_end();
    stream_.reset();
  }

  SamplePart part_;
  std::uint64_t part_bytes_;
  InputFile file_;
  std::optional<UnpackedStream> stream_;
  // Position in the unpacked stream.
  std::uint64_t at_ = 0;
  std::uint64_t behind_ = 0;
};

class SlicesInParts : public StoredSlices {
 public:
  SlicesInParts(SampleParts samples, const ImageHeader& header)
      : samples_(std::move(samples)), header_(header) {
    const std::uint64_t end = samples_.first_byte + header.volume_bytes();
    for (std::uint64_t i = samples_.first_byte / samples_.part_bytes; i * samples_.part_bytes < end;
         ++i) {
      open(i);
      open_->check(std::min(samples_.part_bytes, end - i * samples_.part_bytes));
      note_excess();
    }
  }

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    const std::span<std::byte> all(into, count * header_.slice_bytes());
    std::uint64_t at = samples_.first_byte + first * header_.slice_bytes();
    for (std::span<std::byte> left = all; !left.empty();) {
      open(at / samples_.part_bytes);
      const std::uint64_t in_part = at % samples_.part_bytes;
      const std::size_t bytes = std::min<std::uint64_t>(left.size(), samples_.part_bytes - in_part);
      open_->read(in_part, left.first(bytes));
      note_excess();
      left = left.subspan(bytes);
      at += bytes;
    }
    to_host_order(all, bytes_of(header_.type), samples_.endian);
  }

  [[nodiscard]] std::vector<std::string> findings() const override {
    if (excess_.empty()) return {};
    const auto& [file, bytes] = *excess_.begin();
    return {"'" + file.string() + "'" +
            (excess_.size() > 1 ? " and " + counted(excess_.size() - 1, "other file") + " have "
                                : " has ") +
            counted(bytes, "byte") +
            " more than the header declares. The last ones are ignored; if others come first, "
            "correct the header (HeaderSize = -1 in MetaImage, byte skip: -1 in NRRD)."};
  }

 private:
  void open(std::uint64_t part) {
    if (open_ && index_ == part) return;
    open_.reset();
    open_.emplace(samples_.parts[part], samples_.part_bytes);
    index_ = part;
  }

  void note_excess() {
    if (!samples_.known_behind || open_->behind() <= *samples_.known_behind) return;
    excess_[open_->file()] = open_->behind() - *samples_.known_behind;
  }

  SampleParts samples_;
  ImageHeader header_;
  std::map<fs::path, std::uint64_t> excess_;  // Bytes that no header explains, by file.
  std::optional<OpenPart> open_;
  // Index of the open part.
  std::uint64_t index_ = 0;
};

class InterleavedSlices : public StoredSlices {
 public:
  InterleavedSlices(std::vector<std::unique_ptr<StoredSlices>> components,
                    const ImageHeader& header)
      : components_(std::move(components)), header_(header) {}

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    const std::size_t step = bytes_of(header_.type) * static_cast<std::size_t>(header_.components);
    const std::size_t width = step / components_.size();
    std::vector<std::byte> one(count * header_.slice_bytes() / components_.size());
    for (std::size_t component = 0; component < components_.size(); ++component) {
      components_[component]->read(first, count, one.data());
      for (std::size_t i = 0; i * width < one.size(); ++i) {
        std::memcpy(into + i * step + component * width, one.data() + i * width, width);
      }
    }
  }

  [[nodiscard]] std::vector<std::string> findings() const override {
    return components_.front()->findings();
  }

 private:
  std::vector<std::unique_ptr<StoredSlices>> components_;
  ImageHeader header_;
};

class ScaledSlices : public StoredSlices {
 public:
  ScaledSlices(std::unique_ptr<StoredSlices> stored, StoredType type, std::size_t numbers,
               std::vector<std::array<double, 2>> scales)
      : stored_(std::move(stored)), type_(type), numbers_(numbers), scales_(std::move(scales)) {}

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    std::vector<std::byte> slice(numbers_ * bytes_of(type_));
    for (std::size_t z = first; z < first + count; ++z) {
      stored_->read(z, 1, slice.data());
      const auto [slope, intercept] = scales_[z];
      for (std::size_t i = 0; i < numbers_; ++i, into += sizeof(float)) {
        const double number = number_from(type_, slice.data() + i * bytes_of(type_));
        const auto value = static_cast<float>(slope * number + intercept);
        std::memcpy(into, &value, sizeof value);
      }
    }
  }

  [[nodiscard]] std::vector<std::string> findings() const override { return stored_->findings(); }

 private:
  std::unique_ptr<StoredSlices> stored_;
  StoredType type_;
  std::size_t numbers_;  // In a slice.
  std::vector<std::array<double, 2>> scales_;
};

}  // namespace

std::unique_ptr<StoredSlices> slices_in_parts(SampleParts samples, const ImageHeader& header) {
  return std::make_unique<SlicesInParts>(std::move(samples), header);
}

std::unique_ptr<StoredSlices> plain_slices(const fs::path& file, std::uint64_t offset,
                                           Endian endian, const ImageHeader& header) {
  return slices_in_parts({.parts = {{.file = file, .offset = offset}},
                          .part_bytes = header.volume_bytes(),
                          .endian = endian},
                         header);
}

std::unique_ptr<StoredSlices> slices_in_file(const fs::path& file, std::uint64_t offset,
                                             Endian endian, const ImageHeader& header,
                                             std::optional<std::uint64_t> known_behind) {
  const Packing packing = UnpackedStream::packing_at(InputFile(file), 0);
  const bool is_stream = packing == Packing::kGzip || packing == Packing::kBzip2;
  const SamplePart part = is_stream
                              ? SamplePart{.file = file, .packing = packing, .skipped = offset}
                              : SamplePart{.file = file, .offset = offset};
  return slices_in_parts({.parts = {part},
                          .part_bytes = header.volume_bytes(),
                          .endian = endian,
                          .known_behind = known_behind},
                         header);
}

std::unique_ptr<StoredSlices> interleaved_slices(
    std::vector<std::unique_ptr<StoredSlices>> components, const ImageHeader& header) {
  return std::make_unique<InterleavedSlices>(std::move(components), header);
}

std::unique_ptr<StoredSlices> scaled_slices(std::unique_ptr<StoredSlices> stored, StoredType type,
                                            std::size_t numbers,
                                            std::vector<std::array<double, 2>> scales) {
  return std::make_unique<ScaledSlices>(std::move(stored), type, numbers, std::move(scales));
}

}  // namespace multitetra
