// A prepared file in memory.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "server/dataset/byte_source.hpp"

namespace multitetra {

// Bytes in memory, which must outlive the source.
class MemorySource : public ByteSource {
 public:
  explicit MemorySource(std::span<const std::byte> bytes) : bytes_(bytes) {}

  [[nodiscard]] std::uint64_t size() const override { return bytes_.size(); }
  void read(std::uint64_t offset, std::span<std::byte> into) const override {
    if (!into.empty()) std::memcpy(into.data(), bytes(offset, into.size()).data(), into.size());
  }
  [[nodiscard]] RetainedBytes bytes(std::uint64_t offset, std::size_t size) const override {
    assert(offset <= bytes_.size() && size <= bytes_.size() - offset);
    return bytes_.subspan(static_cast<std::size_t>(offset), size);
  }

 private:
  std::span<const std::byte> bytes_;
};

}  // namespace multitetra
