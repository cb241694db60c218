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

// Recognizes other protocols by their first four bytes, which would be absurd lengths. Returns an
// error text, or nothing for a frame.
std::string foreign_protocol_hint(std::string_view header) {
  if (header == "HTTP") {
    return "The server at this port uses HTTP: write ws:// (with TLS wss://) instead of "
           "tcp:// (tls://).";
  }
  for (const std::string_view method : {"GET ", "HEAD", "POST", "PUT ", "OPTI", "DELE", "CONN"}) {
    if (header != method) continue;
    return "This port takes frames over TCP (tcp://), and an HTTP request came; HTTP, WebSockets "
           "and the viewer have another port.";
  }
  if (header.starts_with("\x15\x03")) {  // An alert.
    return "The server at this port uses TLS: write tls:// or wss:// instead of tcp:// or ws://.";
  }
  if (header.starts_with("\x16\x03")) {
    return "This port does not use TLS, but a TLS handshake arrived: write tcp:// or ws:// instead "
           "of "
           "tls:// or wss://.";
  }
  return {};
}

}  // namespace

void FrameReader::feed(std::string_view bytes) {
  // Drops returned bytes once they are the larger part, so that each byte moves O(1) times.
  if (consumed_ > 0 && consumed_ >= buffer_.size() - consumed_) {
    buffer_.erase(0, consumed_);
    consumed_ = 0;
  }
  buffer_.append(bytes);
}

Result<std::optional<std::string>> FrameReader::next() {
  if (buffered() < kFrameHeaderBytes) return std::nullopt;
  const std::uint32_t length = content_length(buffer_.data() + consumed_);
  // Invalid headers stay in the buffer, so every later call rejects them again.
  if (length == 0) {
    return fail(ErrorCode::kMalformedFrame,
                "A frame has length 0; every frame holds a message of at least 1 byte.");
  }
  if (length > max_content_bytes_) {
    const std::string other =
        foreign_protocol_hint(std::string_view(buffer_).substr(consumed_, kFrameHeaderBytes));
    if (!other.empty()) return fail(ErrorCode::kMalformedFrame, other);
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
