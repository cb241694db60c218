// HTTP requests cut out of a stream of bytes, fed in any portions. No I/O happens here.
//
//   RequestReader requests(16 * 1024);
//   requests.feed(bytes);
//   while (auto request = requests.next(); request && *request) answer(**request);
//
// Requests that were sent ahead (pipelining) come out one after the other. None has a body here:
// one that announces one is refused.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include <boost/beast/http.hpp>
#include <tl/expected.hpp>

namespace multitetra {

namespace http = boost::beast::http;

// The request line and the header fields.
using HttpRequest = http::request<http::empty_body>;

inline std::string_view view_of(boost::beast::string_view text) {
  return {text.data(), text.size()};
}
// The value of a field, empty if it is absent.
inline std::string_view field(const HttpRequest& request, http::field name) {
  return view_of(request[name]);
}

// Why the bytes are no request that can be answered; nothing after them can be either.
struct MalformedRequest {
  int status = 400;
  std::string text;
};

class RequestReader {
 public:
  explicit RequestReader(std::uint32_t max_header_bytes) : max_header_bytes_(max_header_bytes) {}

  void feed(std::string_view bytes);
  // The next request whose header has come as a whole; nullopt when more bytes are needed. From the
  // first refusal on, the same refusal.
  [[nodiscard]] tl::expected<std::optional<HttpRequest>, MalformedRequest> next();

  // Whether a part of a request has come.
  [[nodiscard]] bool is_inside() const { return consumed_ < buffer_.size() || parser_; }
  // Bytes fed beyond the last request.
  [[nodiscard]] std::string_view rest() const {
    return std::string_view(buffer_).substr(consumed_);
  }

 private:
  using Parser = http::request_parser<http::empty_body>;

  tl::unexpected<MalformedRequest> refuse(int status, std::string text);

  std::uint32_t max_header_bytes_;
  std::string buffer_;
  std::size_t consumed_ = 0;
  // For a request that was started.
  std::optional<Parser> parser_;
  std::optional<MalformedRequest> broken_;
};

}  // namespace multitetra
