#include "server/http/http_request.hpp"

#include <iterator>
#include <utility>

namespace multitetra {

using boost::system::error_code;

void RequestReader::feed(std::string_view bytes) {
  if (consumed_ == buffer_.size()) {
    buffer_.clear();
  } else {
    buffer_.erase(0, consumed_);
  }
  consumed_ = 0;
  buffer_.append(bytes);
}

tl::unexpected<MalformedRequest> RequestReader::refuse(int status, std::string text) {
  broken_ = MalformedRequest{.status = status, .text = std::move(text)};
  return tl::unexpected(*broken_);
}

tl::expected<std::optional<HttpRequest>, MalformedRequest> RequestReader::next() {
  if (broken_) return tl::unexpected(*broken_);
  if (consumed_ == buffer_.size()) return std::nullopt;
  if (!parser_) {
    parser_.emplace();
    parser_->header_limit(max_header_bytes_);
    parser_->body_limit(0);
  }
  error_code error;
  while (!parser_->is_header_done() && consumed_ < buffer_.size()) {
    const std::string_view left = rest();
    consumed_ += parser_->put(boost::asio::const_buffer(left.data(), left.size()), error);
    if (error) break;
  }
  const bool is_too_long = error == http::error::header_limit ||
                           (!parser_->is_header_done() && rest().size() > max_header_bytes_);
  if (is_too_long) {
    return refuse(431, "The request's line and header have more than " +
                           std::to_string(max_header_bytes_) + " bytes.");
  }
  if (error == http::error::body_limit) return refuse(413, "A request here has no body.");
  if (error && error != http::error::need_more) {
    return refuse(400, "The bytes are no HTTP/1.1 request: " + error.message() + ".");
  }
  if (!parser_->is_header_done()) return std::nullopt;
  const auto length = parser_->content_length();
  if (parser_->chunked() || (length && *length > 0)) {
    return refuse(413, "A request here has no body.");
  }
  const HttpRequest& header = parser_->get();
  // Refused for any coding: a proxy may see a body where this reader sees the next request.
  if (header.find(http::field::transfer_encoding) != header.end()) {
    return refuse(501, "A request here has no body, and no Transfer-Encoding.");
  }
  const auto hosts = header.equal_range(http::field::host);
  const auto host_lines = std::distance(hosts.first, hosts.second);
  if (host_lines > 1 || (host_lines == 0 && header.version() >= 11)) {
    return refuse(400, "A request names its Host once (RFC 9112).");
  }
  HttpRequest request = parser_->release();
  parser_.reset();
  return request;
}

}  // namespace multitetra
