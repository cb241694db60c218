// Frames on a byte stream: a 4-byte little-endian length, then that many bytes.
//
//   +----+----+----+----+----------------------+
//   |   length (u32 LE)  |  length bytes       |
//   +----+----+----+----+----------------------+
//
// A frame of length 0 is malformed, as no message is empty. This file does no I/O.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/result.hpp"

namespace multitetra {

inline constexpr std::size_t kFrameHeaderBytes = 4;
// Default limits of a frame's content. The longest client message is a request with the maximum
// number of regions, grid thresholds and cached tiles, about 1.4 million bytes.
inline constexpr std::uint32_t kMaxClientFrameBytes = 2 * 1024 * 1024;   // Accepted by servers.
inline constexpr std::uint32_t kMaxHelloFrameBytes = 16 * 1024;          // Before Hello.
inline constexpr std::uint32_t kMaxServerFrameBytes = 16 * 1024 * 1024;  // Accepted by clients.

// Returns the 4 bytes that precede `content_bytes` bytes.
[[nodiscard]] std::string frame_header(std::uint32_t content_bytes);

// Splits a byte stream, fed in chunks of any size, into frames.
class FrameReader {
 public:
  explicit FrameReader(std::uint32_t max_content_bytes) : max_content_bytes_(max_content_bytes) {}

  void feed(std::string_view bytes);
  // Takes effect with the next frame.
  void set_limit(std::uint32_t max_content_bytes) { max_content_bytes_ = max_content_bytes; }

  // Returns the content of the next complete frame; nullopt if more bytes are needed. Fails with
  // kMessageTooLarge or kMalformedFrame as soon as the header is invalid, and in all later calls,
  // since the framing is then lost.
  [[nodiscard]] Result<std::optional<std::string>> next();

  // Returns the number of bytes fed but not yet returned. Memory use is proportional to it.
  [[nodiscard]] std::size_t buffered() const { return buffer_.size() - consumed_; }

 private:
  std::uint32_t max_content_bytes_;
  std::string buffer_;
  std::size_t consumed_ = 0;
};

}  // namespace multitetra
