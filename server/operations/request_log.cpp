#include "server/operations/request_log.hpp"

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

// Connections of HTTP come and go with every request.
LogLevel level_of(const ClientFacts& client) {
  return std::string_view(client.protocol) == "http" ? LogLevel::kDebug : LogLevel::kInfo;
}

LogLevel level_of(std::string_view kind) {
  const bool is_large = kind == "stream" || kind == "estimate" || kind == "isosurface";
  return is_large ? LogLevel::kInfo : LogLevel::kDebug;
}

LogLevel level_of(int status) {
  if (status >= 500) return LogLevel::kWarning;
  return status >= 400 ? LogLevel::kInfo : LogLevel::kDebug;
}

// The client's number, or over HTTP our word.
LogValue request_of(const RequestFacts& facts) {
  if (facts.id.empty()) return facts.request;
  return facts.id;
}

}  // namespace

void RequestLog::connected(const ClientFacts& client) {
  log_line(level_of(client), "connected",
           {{"connection", client.connection}, {"door", client.protocol}, {"peer", client.peer}});
}

void RequestLog::disconnected(const ClientFacts& client, double seconds) {
  log_line(level_of(client), "disconnected",
           {{"connection", client.connection},
            {"door", client.protocol},
            {"peer", client.peer},
            {"name", unless_empty(client.name)},
            {"seconds", seconds}});
}

void RequestLog::refused(const ClientFacts& client, const char* limit) {
  log_line(LogLevel::kWarning, "refused",
           {{"connection", client.connection},
            {"door", client.protocol},
            {"peer", client.peer},
            {"limit", limit}});
}

void RequestLog::request_ended(const ClientFacts& client, const RequestFacts& facts) {
  log_line(level_of(facts.kind), facts.kind,
           {{"connection", client.connection},
            {"request", request_of(facts)},
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
            {"outcome", facts.outcome}});
}

void RequestLog::error_answered(const ClientFacts& client, const Error& error,
                                std::uint64_t request) {
  log_line(LogLevel::kInfo, error.text,
           {{"connection", client.connection},
            {"request", unless_zero(request)},
            {"peer", client.peer},
            {"name", unless_empty(client.name)},
            {"code", name(error.code)}});
}

void RequestLog::http_answered(const ClientFacts& client, const HttpFacts& facts) {
  constexpr std::size_t kLongestTarget = 500;
  log_line(level_of(facts.status), "http",
           {{"connection", client.connection},
            {"request", unless_empty(facts.id)},
            {"peer", client.peer},
            {"name", unless_empty(client.name)},
            {"kind", facts.kind},
            {"method", unless_empty(facts.method)},
            {"target", unless_empty(facts.target.substr(0, kLongestTarget))},
            {"status", static_cast<std::uint64_t>(facts.status)},
            {"bytes", unless_zero(facts.bytes)},
            {"seconds", facts.seconds}});
}

}  // namespace multitetra
