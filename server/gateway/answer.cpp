#include "server/gateway/answer.hpp"

#include <ctime>
#include <utility>

#include <boost/beast/http/status.hpp>
#include <nlohmann/json.hpp>

namespace multitetra {
namespace {

// The Date field's value (RFC 9110), made once a second.
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

bool may_have_body(int status) { return status >= 200 && status != 204 && status != 304; }

}  // namespace

std::size_t Answer::body_bytes() const {
  if (const auto* shared = std::get_if<SharedBytes>(&body)) return *shared ? (*shared)->size() : 0;
  return std::get<std::string>(body).size();
}

void add_field(Answer& answer, std::string_view name, std::string_view value) {
  answer.fields.append(name).append(": ").append(value).append("\r\n");
}

Answer json_answer(int status, std::string json) {
  Answer answer{.status = status, .body = std::move(json)};
  add_field(answer, "Content-Type", "application/json");
  return answer;
}

Answer error_answer(int status, const Error& error, std::string_view request_id) {
  const nlohmann::ordered_json body = {
      {"error", {{"code", name(error.code)}, {"text", error.text}, {"request_id", request_id}}}};
  Answer answer = json_answer(
      status, body.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  add_field(answer, "Cache-Control", "no-store");
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
  if (may_have_body(answer.status)) {
    head.append("Content-Length: ").append(std::to_string(answer.body_bytes())).append("\r\n");
  }
  if (!keep_alive) head.append("Connection: close\r\n");
  head.append(answer.fields).append("\r\n");
  return head;
}

}  // namespace multitetra
