#include "server/dataset/formats/plain_slices.hpp"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "server/dataset/formats/input_file.hpp"
#include "server/dataset/formats/unpacking.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

std::span<std::byte> bytes_for(const ImageHeader& header, std::size_t slices, std::byte* into) {
  return {into, slices * header.slice_bytes()};
}

class SlicesAsTheyAre : public StoredSlices {
 public:
  SlicesAsTheyAre(const fs::path& file, std::uint64_t offset, Endian endian,
                  const ImageHeader& header)
      : file_(file), offset_(offset), endian_(endian), header_(header) {
    const std::uint64_t needed = header.slice_bytes() * static_cast<std::uint64_t>(header.dims[2]);
    const std::uint64_t found = file_.size() < offset ? 0 : file_.size() - offset;
    if (found >= needed) return;
    fail_reading(file,
                 "it ends too early or is damaged; its header promises " + std::to_string(needed) +
                     " bytes of samples and " + std::to_string(found) + " are there",
                 "Get a whole copy of it");
  }

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    const std::span<std::byte> bytes = bytes_for(header_, count, into);
    file_.read(offset_ + first * header_.slice_bytes(), bytes);
    to_host_order(bytes, bytes_of(header_.type), endian_);
  }

 private:
  InputFile file_;
  std::uint64_t offset_;
  Endian endian_;
  ImageHeader header_;
};

class PackedSlices : public StoredSlices {
 public:
  PackedSlices(const fs::path& file, std::uint64_t packed_offset, std::uint64_t offset,
               Endian endian, const ImageHeader& header)
      : file_(file),
        packed_offset_(packed_offset),
        offset_(offset),
        endian_(endian),
        header_(header),
        packing_(UnpackedStream::packing_at(file_, packed_offset)) {
    if (packing_ == Packing::kNone) {
      fail_reading(file, "its samples are no gzip, zlib or bzip2 stream", "Get a whole copy of it");
    }
  }

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    if (!stream_ || first < next_) {
      stream_.emplace(file_, packed_offset_, packing_);
      next_ = 0;
      skip(offset_);
    }
    skip((first - next_) * header_.slice_bytes());
    const std::span<std::byte> bytes = bytes_for(header_, count, into);
    take(bytes, first);
    to_host_order(bytes, bytes_of(header_.type), endian_);
    next_ = first + count;
    if (next_ == static_cast<std::size_t>(header_.dims[2])) require_end();
  }

 private:
  // Behind the last slice: other times may follow, but only a stream that ends well is known to
  // hold the bytes that were packed.
  void require_end() {
    stream_->require_good_end();
    stream_.reset();
  }

  void take(std::span<std::byte> bytes, std::size_t slice) {
    if (stream_->read_some(bytes) == bytes.size()) return;
    fail_reading(file_.path(),
                 "its packed samples end in or after slice " + std::to_string(slice) + " of " +
                     std::to_string(header_.dims[2]),
                 "Get a whole copy of it");
  }

  void skip(std::uint64_t bytes) {
    std::vector<std::byte> portion(std::min<std::uint64_t>(bytes, std::uint64_t{1} << 20));
    while (bytes > 0) {
      const std::size_t count = std::min<std::uint64_t>(bytes, portion.size());
      take(std::span(portion).first(count), next_);
      bytes -= count;
    }
  }

  InputFile file_;
  std::uint64_t packed_offset_;
  std::uint64_t offset_;
  Endian endian_;
  ImageHeader header_;
  Packing packing_;
  std::optional<UnpackedStream> stream_;
  std::size_t next_ = 0;  // The slice that the stream is at.
};

}  // namespace

std::unique_ptr<StoredSlices> plain_slices(const fs::path& file, std::uint64_t offset,
                                           Endian endian, const ImageHeader& header) {
  return std::make_unique<SlicesAsTheyAre>(file, offset, endian, header);
}

std::unique_ptr<StoredSlices> packed_slices(const fs::path& file, std::uint64_t packed_offset,
                                            std::uint64_t offset, Endian endian,
                                            const ImageHeader& header) {
  return std::make_unique<PackedSlices>(file, packed_offset, offset, endian, header);
}

std::unique_ptr<StoredSlices> slices_in_file(const fs::path& file, std::uint64_t offset,
                                             Endian endian, const ImageHeader& header) {
  const Packing packing = UnpackedStream::packing_at(InputFile(file), 0);
  if (packing == Packing::kGzip || packing == Packing::kBzip2) {
    return packed_slices(file, 0, offset, endian, header);
  }
  return plain_slices(file, offset, endian, header);
}

}  // namespace multitetra
