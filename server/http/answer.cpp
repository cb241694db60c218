#include "server/http/answer.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <span>
#include <utility>

#include <boost/beast/http/status.hpp>

#include "common/base/hex_text.hpp"
#include "common/base/json.hpp"
#include "server/dataset/checksum.hpp"
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

std::string_view outcome_of(const Answer& answer) {
  return answer.error ? name(answer.error->code) : "complete";
}

std::size_t memory_of(const Answer& answer) {
  constexpr std::uint64_t kSmall = 16 * 1024;
  const Body& body = answer.body;
  if (body.is_resident) return 0;
  const std::uint64_t bytes = std::holds_alternative<SharedFile>(body.whole)
                                  ? std::min(body.length, kFilePieceBytes)
                                  : body.length;
  return bytes > kSmall ? bytes : 0;
}

void add_field(Answer& answer, std::string_view name, std::string_view value) {
  answer.fields.append(name).append(": ").append(value).append("\r\n");
}

Answer json_answer(int status, std::string json) {
  Answer answer{.status = status, .fields = {}, .body = body_of(std::move(json))};
  add_field(answer, "Content-Type", "application/json");
  return answer;
}

Answer error_answer(int status, const Error& error, std::string_view request_id) {
  const nlohmann::ordered_json body = {{"error",
                                        {{"code", name(error.code)},
                                         {"text", without_secrets(error.text)},
                                         {"request_id", request_id}}}};
  Answer answer = json_answer(status, json_text(body) + "\n");
  answer.error = error;
  add_field(answer, "Cache-Control", "no-store");
  if (status == 503 || status == 429) {
    constexpr double kLongest = 3600;
    const double seconds = std::clamp(std::ceil(error.retry_after), 1.0, kLongest);
    add_field(answer, "Retry-After", std::to_string(static_cast<int>(seconds)));
  }
  return answer;
}

Answer error_answer(const Error& error, std::string_view request_id) {
  Answer answer = error_answer(status_of(error.code), error, request_id);
  if (answer.status == 401) add_field(answer, "WWW-Authenticate", "Bearer");
  return answer;
}

std::string tag_of(std::string_view content) {
  const auto bytes = std::as_bytes(std::span(content.data(), content.size()));
  return '"' + hex_text(checksum(bytes)) + '"';
}

bool needs_body(const HttpRequest& request, std::string_view tag) {
  if (request.method() == http::verb::head) return false;
  return tag.empty() || !matches_tag(field(request, http::field::if_none_match), tag);
}

void apply_conditions(Answer& answer, const HttpRequest& request, std::string_view tag) {
  add_field(answer, "ETag", tag);
  if (matches_tag(field(request, http::field::if_none_match), tag)) {
    answer.status = 304;
    answer.body = {};
    return;
  }
  add_field(answer, "Accept-Ranges", "bytes");
  if (!answer.is_length_known || request.method() != http::verb::get) return;
  const std::string of = "/" + std::to_string(answer.body.length);
  const RangeOutcome outcome =
      range_of(field(request, http::field::range), field(request, http::field::if_range), tag,
               answer.body.length);
  if (const auto* range = std::get_if<ByteRange>(&outcome)) {
    answer.status = 206;
    answer.body = part_of(std::move(answer.body), *range);
    add_field(answer, "Content-Range",
              "bytes " + std::to_string(range->first) + "-" +
                  std::to_string(range->first + range->length - 1) + of);
  } else if (std::holds_alternative<RangeNotSatisfiable>(outcome)) {
    answer.status = 416;
    answer.body = {};
    add_field(answer, "Content-Range", "bytes *" + of);
  }
}

Answer document_answer(std::string json, const HttpRequest& request) {
  const std::string tag = tag_of(json);
  Answer answer = json_answer(200, std::move(json));
  add_field(answer, "Cache-Control", "no-cache");
  apply_conditions(answer, request, tag);
  return answer;
}

std::string head_of(const Answer& answer, bool keep_alive) {
  const auto reason = boost::beast::http::obsolete_reason(
      boost::beast::http::int_to_status(static_cast<unsigned>(answer.status)));
  std::string head;
  head.reserve(answer.fields.size() + 256);
  head.append("HTTP/1.1 ").append(std::to_string(answer.status)).append(" ");
  head.append(reason.data(), reason.size()).append("\r\nServer: multitetra\r\nDate: ");
  head.append(date_now()).append("\r\n");
  if (may_have_body(answer.status) && answer.is_length_known) {
    head.append("Content-Length: ").append(std::to_string(answer.body.length)).append("\r\n");
  }
  if (!keep_alive) head.append("Connection: close\r\n");
  head.append(answer.fields).append("\r\n");
  return head;
}

}  // namespace multitetra
