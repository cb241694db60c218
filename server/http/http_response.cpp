#include "server/http/http_response.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <span>
#include <utility>

#include <boost/beast/http/status.hpp>

#include "common/base/hex_text.hpp"
#include "common/base/json.hpp"
#include "common/mesh/checksum.hpp"
#include "server/http/conditions.hpp"
#include "server/operations/secrets.hpp"

namespace multitetra {
namespace {

// Returns the value of the Date field (RFC 9110), formatted once a second.
const std::string& date_now() {
  thread_local std::time_t at = 0;
  thread_local std::string text;
  const std::time_t now = std::time(nullptr);
  if (now != at) {
    at = now;
    std::tm parts{};
    gmtime_r(&now, &parts);
    char buffer[40];
    const std::size_t size =
        std::strftime(buffer, sizeof buffer, "%a, %d %b %Y %H:%M:%S GMT", &parts);
    text.assign(buffer, size);
  }
  return text;
}

int status_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kUnknownDataset:
      return 404;
    case ErrorCode::kLimitExceeded:
      return 422;
    case ErrorCode::kMalformedFrame:
    case ErrorCode::kMessageTooLarge:
    case ErrorCode::kMalformedMessage:
    case ErrorCode::kUnsupportedVersion:
    case ErrorCode::kUnexpectedMessage:
    case ErrorCode::kInvalidArgument:
      return 400;
    case ErrorCode::kCancelled:
    case ErrorCode::kUnavailable:
      return 503;
    case ErrorCode::kUnauthenticated:
      return 401;
    case ErrorCode::kPermissionDenied:
      return 403;
    case ErrorCode::kUnknown:
    case ErrorCode::kDamagedData:
    case ErrorCode::kInternal:
      break;
  }
  return 500;
}

// Copies bytes in memory, so that an answer retains only what it sends.
Body part_of(Body body, const ByteRange& range) {
  const bool is_file = std::holds_alternative<SharedFile>(body.whole);
  if (is_file || body.is_resident || range.length == body.length) {
    body.first = range.first;
    body.length = range.length;
    return body;
  }
  const auto* shared = std::get_if<SharedBytes>(&body.whole);
  const std::string& whole = shared ? **shared : std::get<std::string>(body.whole);
  return body_of(whole.substr(range.first, range.length));
}

bool may_have_body(int status) { return status >= 200 && status != 204 && status != 304; }

}  // namespace

Body body_of(std::string text) {
  const std::size_t size = text.size();
  return {.whole = std::move(text), .first = 0, .length = size};
}

Body body_of(SharedBytes bytes) {
  const std::size_t size = bytes->size();
  return {.whole = std::move(bytes), .first = 0, .length = size};
}

Body body_of(SharedFile file, std::uint64_t size) {
  return {.whole = std::move(file), .first = 0, .length = size};
}

std::string_view outcome_of(const HttpResponse& response) {
  return response.error ? name(response.error->code) : "complete";
}

std::size_t memory_of(const HttpResponse& response) {
  constexpr std::uint64_t kSmall = 16 * 1024;
  const Body& body = response.body;
  if (body.is_resident) return 0;
  const std::uint64_t bytes = std::holds_alternative<SharedFile>(body.whole)
                                  ? std::min(body.length, kFilePieceBytes)
                                  : body.length;
  return bytes > kSmall ? bytes : 0;
}

void add_field(HttpResponse& response, std::string_view name, std::string_view value) {
  response.fields.append(name).append(": ").append(value).append("\r\n");
}

HttpResponse json_answer(int status, std::string json) {
  HttpResponse response{.status = status, .fields = {}, .body = body_of(std::move(json))};
  add_field(response, "Content-Type", "application/json");
  return response;
}

HttpResponse error_answer(int status, const Error& error, std::string_view request_id) {
  const nlohmann::ordered_json body = {{"error",
                                        {{"code", name(error.code)},
                                         {"text", without_secrets(error.text)},
                                         {"request_id", request_id}}}};
  HttpResponse response = json_answer(status, json_text(body) + "\n");
  response.error = error;
  add_field(response, "Cache-Control", "no-store");
  if (status == 503 || status == 429) {
    constexpr double kLongest = 3600;
    const double seconds = std::clamp(std::ceil(error.retry_after), 1.0, kLongest);
    add_field(response, "Retry-After", std::to_string(static_cast<int>(seconds)));
  }
  return response;
}

HttpResponse error_answer(const Error& error, std::string_view request_id) {
  HttpResponse response = error_answer(status_of(error.code), error, request_id);
  if (response.status == 401) add_field(response, "WWW-Authenticate", "Bearer");
  return response;
}

std::string tag_of(std::string_view content) {
  const auto bytes = std::as_bytes(std::span(content.data(), content.size()));
  return '"' + hex_text(checksum(bytes)) + '"';
}

bool needs_body(const HttpRequest& request, std::string_view tag) {
  if (request.method() == http::verb::head) return false;
  return tag.empty() || !matches_tag(field(request, http::field::if_none_match), tag);
}

void apply_conditions(HttpResponse& response, const HttpRequest& request, std::string_view tag) {
  add_field(response, "ETag", tag);
  if (matches_tag(field(request, http::field::if_none_match), tag)) {
    response.status = 304;
    response.body = {};
    return;
  }
  add_field(response, "Accept-Ranges", "bytes");
  if (!response.is_length_known || request.method() != http::verb::get) return;
  const std::string of = "/" + std::to_string(response.body.length);
  const RangeOutcome outcome =
      range_of(field(request, http::field::range), field(request, http::field::if_range), tag,
               response.body.length);
  if (const auto* range = std::get_if<ByteRange>(&outcome)) {
    response.status = 206;
    response.body = part_of(std::move(response.body), *range);
    add_field(response, "Content-Range",
              "bytes " + std::to_string(range->first) + "-" +
                  std::to_string(range->first + range->length - 1) + of);
  } else if (std::holds_alternative<RangeNotSatisfiable>(outcome)) {
    response.status = 416;
    response.body = {};
    add_field(response, "Content-Range", "bytes *" + of);
  }
}

HttpResponse document_answer(std::string json, const HttpRequest& request) {
  const std::string tag = tag_of(json);
  HttpResponse response = json_answer(200, std::move(json));
  add_field(response, "Cache-Control", "no-cache");
  apply_conditions(response, request, tag);
  return response;
}

std::string head_of(const HttpResponse& response, bool keep_alive) {
  const auto reason = boost::beast::http::obsolete_reason(
      boost::beast::http::int_to_status(static_cast<unsigned>(response.status)));
  std::string head;
  head.reserve(response.fields.size() + 256);
  head.append("HTTP/1.1 ").append(std::to_string(response.status)).append(" ");
  head.append(reason.data(), reason.size()).append("\r\nServer: multitetra\r\nDate: ");
  head.append(date_now()).append("\r\n");
  if (may_have_body(response.status) && response.is_length_known) {
    head.append("Content-Length: ").append(std::to_string(response.body.length)).append("\r\n");
  }
  if (!keep_alive) head.append("Connection: close\r\n");
  head.append(response.fields).append("\r\n");
  return head;
}

}  // namespace multitetra
