#include "server/dataset/plain_payload.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

#include "server/dataset/image_file.hpp"
#include "server/dataset/payload_size.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

// Swaps the bytes of every number. The width is a constant, so that this is one instruction each.
template <typename Number>
void turn_numbers(std::byte* bytes, std::uint64_t count) {
  for (std::uint64_t at = 0; at < count; at += sizeof(Number)) {
    std::array<std::byte, sizeof(Number)> number;
    std::memcpy(number.data(), bytes + at, sizeof(Number));
    std::reverse(number.begin(), number.end());
    std::memcpy(bytes + at, number.data(), sizeof(Number));
  }
}

void turn_numbers(std::byte* bytes, std::uint64_t count, std::size_t width) {
  if (width == 2) turn_numbers<std::uint16_t>(bytes, count);
  if (width == 4) turn_numbers<std::uint32_t>(bytes, count);
  if (width == 8) turn_numbers<std::uint64_t>(bytes, count);
}

}  // namespace

class PayloadReader::OpenFile {
 public:
  explicit OpenFile(fs::path file)
      : file_(std::move(file)), descriptor_(open(file_.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (descriptor_ < 0) fail(std::strerror(errno));
  }
  ~OpenFile() { close(descriptor_); }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  void read(std::uint64_t offset, std::uint64_t count, std::byte* into) const {
    while (count > 0) {
      const ssize_t got =
          pread(descriptor_, into, static_cast<std::size_t>(count), static_cast<off_t>(offset));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) fail(std::strerror(errno));
      if (got == 0) fail("it has become shorter since it was opened");
      offset += static_cast<std::uint64_t>(got);
      count -= static_cast<std::uint64_t>(got);
      into += got;
    }
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const {
    fail_reading(file_, problem, "Check its permissions and disk");
  }

  fs::path file_;
  int descriptor_;
};

PayloadReader::PayloadReader(PlainPayload payload) : payload_(std::move(payload)) {
  for (const PayloadPart& part : payload_.parts) {
    require_whole(part.file, bytes_after(part.file, part.offset), payload_.part_bytes);
  }
}

PayloadReader::~PayloadReader() = default;
PayloadReader::PayloadReader(PayloadReader&&) noexcept = default;

void PayloadReader::read(std::uint64_t first, std::uint64_t count, std::size_t width,
                         std::byte* into) {
  assert(first % width == 0 && count % width == 0);
  assert(first + count <= payload_.parts.size() * payload_.part_bytes);
  std::byte* next = into;
  for (std::uint64_t at = first, left = count; left > 0;) {
    const auto index = static_cast<std::size_t>(at / payload_.part_bytes);
    const std::uint64_t in_part = at % payload_.part_bytes;
    const std::uint64_t bytes = std::min(left, payload_.part_bytes - in_part);
    const PayloadPart& part = payload_.parts[index];
    if (!open_file_ || open_part_ != index) {
      open_file_.reset();
      open_file_ = std::make_unique<OpenFile>(part.file);
      open_part_ = index;
    }
    open_file_->read(part.offset + in_part, bytes, next);
    at += bytes;
    left -= bytes;
    next += bytes;
  }
  constexpr bool kHostIsLittle = std::endian::native == std::endian::little;
  if ((payload_.endian == Endian::kLittle) != kHostIsLittle) turn_numbers(into, count, width);
}

}  // namespace multitetra
