#include "server/operations/request_log.hpp"

#include <initializer_list>
#include <string>

#include "server/operations/log.hpp"

namespace multitetra {
namespace {

std::optional<LogValue> unless_empty(std::string_view text) {
  if (text.empty()) return std::nullopt;
  return text;
}

std::optional<LogValue> if_any(const std::optional<double>& value) {
  if (!value) return std::nullopt;
  return *value;
}

std::optional<LogValue> unless_zero(std::uint64_t value) {
  if (value == 0) return std::nullopt;
  return value;
}

// HTTP connections and health probes are too frequent for level info.
LogLevel level_of(const ClientFacts& client) {
  return client.is_welcomed ? LogLevel::kInfo : LogLevel::kDebug;
}

// Server failures and lack of capacity (with a retry delay) are warnings.
LogLevel level_of(const Error& error) {
  const bool is_full = error.code == ErrorCode::kUnavailable && error.retry_after > 0;
  return is_full || error.code == ErrorCode::kInternal ? LogLevel::kWarning : LogLevel::kInfo;
}

LogLevel level_of(int status) {
  if (status >= 500) return LogLevel::kWarning;
  return status >= 400 ? LogLevel::kInfo : LogLevel::kDebug;
}

}  // namespace

void RequestLog::connected(const ClientFacts& client) {
  log_line_about(
      client.peer, level_of(client), "accepted",
      {{"connection", client.connection}, {"transport", client.protocol}, {"peer", client.peer}});
}

void RequestLog::welcomed(const ClientFacts& client) {
  log_line_about(client.peer, level_of(client), "connected",
                 {{"connection", client.connection},
                  {"transport", client.protocol},
                  {"peer", client.peer},
                  {"name", unless_empty(client.name)}});
}

void RequestLog::disconnected(const ClientFacts& client, double seconds) {
  log_line_about(client.peer, level_of(client), "disconnected",
                 {{"connection", client.connection},
                  {"transport", client.protocol},
                  {"peer", client.peer},
                  {"name", unless_empty(client.name)},
                  {"seconds", seconds}});
}

void RequestLog::refused(const ClientFacts& client, const char* limit) {
  // The line of the answer, over HTTP also that of a refused connection, has the reason.
  const std::string_view text = limit;
  const bool has_answer = std::string_view(client.protocol) == "http";
  const LogLevel level = text == "idle_seconds"                           ? LogLevel::kInfo
                         : text.starts_with("connections") && !has_answer ? LogLevel::kWarning
                                                                          : LogLevel::kDebug;
  log_line_about(client.peer, level, "refused",
                 {{"connection", client.connection},
                  {"transport", client.protocol},
                  {"peer", client.peer},
                  {"limit", limit}});
}

void RequestLog::request_ended(const ClientFacts& client, const RequestFacts& facts) {
  // http_answered logs a rejection over HTTP.
  const bool is_rejection = !facts.id.empty() && facts.outcome != "complete" &&
                            facts.outcome != "cancelled" && facts.outcome != "left";
  const LogLevel level = is_rejection    ? LogLevel::kDebug
                         : facts.failure ? level_of(*facts.failure)
                                         : LogLevel::kInfo;
  // The X-Request-Id over HTTP, else the client's request id.
  const std::string request = facts.id.empty() ? std::to_string(facts.request) : facts.id;
  const auto write = [&](std::initializer_list<LogField> fields) {
    // Only incomplete requests can flood the log, so only they are limited.
    if (facts.outcome == "complete") {
      log_line(level, facts.kind, fields);
    } else {
      log_line_about(client.peer, level, facts.kind, fields);
    }
  };
  write({{"connection", client.connection},
         {"request", request},
         {"transport", client.protocol},
         {"peer", client.peer},
         {"name", unless_empty(client.name)},
         {"dataset", unless_empty(facts.dataset)},
         {"isovalue", if_any(facts.isovalue)},
         {"error", if_any(facts.error)},
         {"unit", unless_empty(facts.unit)},
         {"steps", unless_zero(facts.steps)},
         {"tiles", unless_zero(facts.tiles)},
         {"bytes", unless_zero(facts.bytes)},
         {"first_tile_seconds", if_any(facts.seconds_to_first_tile)},
         {"last_tile_seconds", if_any(facts.seconds_to_last_tile)},
         {"seconds", facts.seconds},
         {"outcome", facts.outcome},
         {"reason", facts.failure ? unless_empty(facts.failure->text) : std::nullopt}});
}

void RequestLog::error_answered(const ClientFacts& client, const Error& error,
                                std::uint64_t request) {
  if (std::string_view(client.protocol) == "http") return;
  const std::string id = request == 0 ? "" : std::to_string(request);
  log_line_about(client.peer, level_of(error), "error",
                 {{"connection", client.connection},
                  {"request", unless_empty(id)},
                  {"transport", client.protocol},
                  {"peer", client.peer},
                  {"name", unless_empty(client.name)},
                  {"outcome", name(error.code)},
                  {"reason", error.text}});
}

void RequestLog::http_answered(const ClientFacts& client, const HttpFacts& facts) {
  constexpr std::size_t kLongestTarget = 500;
  const std::string_view target = facts.target.substr(0, kLongestTarget);
  log_line_about(client.peer, level_of(facts.status), "http",
                 {{"connection", client.connection},
                  {"request", unless_empty(facts.id)},
                  {"proxy_request", unless_empty(facts.proxy_id)},
                  {"transport", client.protocol},
                  {"peer", client.peer},
                  {"name", unless_empty(client.name)},
                  {"kind", facts.kind},
                  {"method", unless_empty(facts.method)},
                  {"target", unless_empty(target)},
                  {"dataset", unless_empty(facts.dataset)},
                  {"status", static_cast<std::uint64_t>(facts.status)},
                  {"bytes", unless_zero(facts.bytes)},
                  {"seconds", facts.seconds},
                  {"outcome", facts.outcome},
                  {"reason", unless_empty(facts.reason)}});
}

}  // namespace multitetra
