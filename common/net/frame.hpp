// Frames on a byte stream: a 4-byte little-endian length, then that many bytes.
//
//   +----+----+----+----+----------------------+
//   |   length (u32 LE)  |  length bytes       |
//   +----+----+----+----+----------------------+
//
// A frame of length 0 is malformed: no message is empty. No I/O happens here.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/result.hpp"

namespace multitetra {

inline constexpr std::size_t kFrameHeaderBytes = 4;
// Default limits on the length of one frame's content. A client's longest message is a request with
// all the regions, grid thresholds and held tiles that are allowed, about 1.4 million bytes.
inline constexpr std::uint32_t kMaxClientFrameBytes = 2 * 1024 * 1024;   // What a server accepts.
inline constexpr std::uint32_t kMaxHelloFrameBytes = 16 * 1024;          // Before Hello.
inline constexpr std::uint32_t kMaxServerFrameBytes = 16 * 1024 * 1024;  // What a client accepts.

// The 4 bytes that precede `content_bytes` bytes.
[[nodiscard]] std::string frame_header(std::uint32_t content_bytes);

// Cuts a stream of bytes, fed in any portions, into frames.
class FrameReader {
 public:
  explicit FrameReader(std::uint32_t max_content_bytes) : max_content_bytes_(max_content_bytes) {}

  void feed(std::string_view bytes);
  // From the next frame on.
  void set_limit(std::uint32_t max_content_bytes) { max_content_bytes_ = max_content_bytes; }

  // The next whole frame's content; nullopt when more bytes are needed. kMessageTooLarge or
  // kMalformedFrame as soon as the header shows it, and from then on: the stream cannot be followed
  // any more.
  [[nodiscard]] Result<std::optional<std::string>> next();

  // Bytes fed and not yet returned. Memory is proportional to it.
  [[nodiscard]] std::size_t buffered() const { return buffer_.size() - consumed_; }

 private:
  std::uint32_t max_content_bytes_;
  std::string buffer_;
  std::size_t consumed_ = 0;
};

}  // namespace multitetra
