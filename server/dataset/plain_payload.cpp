#include "server/dataset/plain_payload.hpp"

#include <algorithm>
#include <cassert>
#include <span>
#include <utility>

#include "server/dataset/payload_size.hpp"

namespace multitetra {

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
      open_file_ = std::make_unique<InputFile>(part.file);
      open_part_ = index;
    }
    open_file_->read(part.offset + in_part, {next, static_cast<std::size_t>(bytes)});
    at += bytes;
    left -= bytes;
    next += bytes;
  }
  to_host_order({into, static_cast<std::size_t>(count)}, width, payload_.endian);
}

}  // namespace multitetra
