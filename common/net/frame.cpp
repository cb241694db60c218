#include "common/net/frame.hpp"

namespace multitetra {

std::string frame_header(std::uint32_t content_bytes) {
  std::string header(kFrameHeaderBytes, '\0');
  for (std::size_t i = 0; i < kFrameHeaderBytes; ++i) {
    header[i] = static_cast<char>(content_bytes >> (8 * i) & 0xFF);
  }
  return header;
}

namespace {

std::uint32_t content_length(const char* header) {
  std::uint32_t length = 0;
  for (std::size_t i = 0; i < kFrameHeaderBytes; ++i) {
    length |= static_cast<std::uint32_t>(static_cast<unsigned char>(header[i])) << (8 * i);
  }
  return length;
}

}  // namespace

void FrameReader::feed(std::string_view bytes) {
  // What was returned is dropped once it is the larger part, so that bytes move O(1) times each.
  if (consumed_ > 0 && consumed_ >= buffer_.size() - consumed_) {
    buffer_.erase(0, consumed_);
    consumed_ = 0;
  }
  buffer_.append(bytes);
}

Result<std::optional<std::string>> FrameReader::next() {
  if (buffered() < kFrameHeaderBytes) return std::nullopt;
  const std::uint32_t length = content_length(buffer_.data() + consumed_);
  // The header stays in the buffer when it is refused: every later call refuses it again.
  if (length == 0) {
    return fail(ErrorCode::kMalformedFrame,
                "A frame has length 0; every frame holds a message of at least 1 byte.");
  }
  if (length > max_content_bytes_) {
    return fail(ErrorCode::kMessageTooLarge,
                "A frame announces " + std::to_string(length) + " bytes; at most " +
                    std::to_string(max_content_bytes_) + " are accepted here.");
  }
  if (buffered() - kFrameHeaderBytes < length) return std::nullopt;
  std::string content = buffer_.substr(consumed_ + kFrameHeaderBytes, length);
  consumed_ += kFrameHeaderBytes + length;
  return content;
}

}  // namespace multitetra
