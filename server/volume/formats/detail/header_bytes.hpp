// Reads numbers at fixed offsets of a binary header.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstring>
#include <span>
#include <string>

#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/unpacking.hpp"
#include "server/volume/formats/endian.hpp"

namespace multitetra {

class HeaderBytes {
 public:
  HeaderBytes(std::string bytes, Endian endian) : bytes_(std::move(bytes)), endian_(endian) {}

  // Requires that the number lies within the header.
  template <typename Number>
  [[nodiscard]] Number at(std::size_t offset) const {
    assert(offset + sizeof(Number) <= bytes_.size());
    Number number;
    std::memcpy(&number, bytes_.data() + offset, sizeof(number));
    to_host_order(std::as_writable_bytes(std::span(&number, 1)), sizeof(number), endian_);
    return number;
  }

 private:
  std::string bytes_;
  Endian endian_;
};

// Returns the first bytes of a file, unpacked if it is a gzip or bzip2 stream; fewer than `count`
// if there are no more or the stream is damaged.
[[nodiscard]] std::string unpacked_beginning(const InputFile& file, std::size_t count);

}  // namespace multitetra
