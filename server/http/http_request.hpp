// Splits a stream of bytes, fed in any portions, into HTTP requests. No I/O happens here.
//
//   RequestReader requests(16 * 1024);
//   requests.feed(bytes);
//   while (auto request = requests.next(); request && *request) answer(**request);
//
// Pipelined requests are returned one after the other. Requests with a body are refused.
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
// Returns the value of a field; empty if absent.
inline std::string_view field(const HttpRequest& request, http::field name) {
  return view_of(request[name]);
}

// The answer to bytes that are not a valid request. No later bytes can be parsed either.
struct MalformedRequest {
  int status = 400;
  std::string text;
};

class RequestReader {
 public:
  explicit RequestReader(std::uint32_t max_header_bytes) : max_header_bytes_(max_header_bytes) {}

  void feed(std::string_view bytes);
  // Returns the next request with a complete header, or nullopt if more bytes are needed. After the
  // first refusal, returns it for ever.
  [[nodiscard]] tl::expected<std::optional<HttpRequest>, MalformedRequest> next();

  // Returns whether part of a request has been fed.
  [[nodiscard]] bool is_inside() const { return consumed_ < buffer_.size() || parser_; }
  // Returns the bytes after the last request.
  [[nodiscard]] std::string_view rest() const {
    return std::string_view(buffer_).substr(consumed_);
  }

 private:
  using Parser = http::request_parser<http::empty_body>;

  tl::unexpected<MalformedRequest> refuse(int status, std::string text);

  std::uint32_t max_header_bytes_;
  std::string buffer_;
  std::size_t consumed_ = 0;
  // Set while a header is incomplete.
  std::optional<Parser> parser_;
  std::optional<MalformedRequest> broken_;
};

}  // namespace multitetra
