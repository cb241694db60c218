// The log, as text for people or JSON for machines, with fields.
//
//   start_log({.format = LogFormat::kJson});
//   log_line(LogLevel::kInfo, "stream ended", {{"connection", id}, {"dataset", name}});
//
//   text  2026-01-31 12:00:00.123 info stream ended connection=7 dataset=head
//   json  {"time":"2026-01-31T12:00:00.123456Z","level":"info","text":"stream ended",
//          "connection":7,"dataset":"head"}
//
// Each event is one line, whatever external bytes it contains: control characters are escaped in
// both formats. spdlog, which writes the lines, is private to log.cpp.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

namespace multitetra {

enum class LogFormat { kText, kJson };
enum class LogLevel { kDebug, kInfo, kWarning, kError, kOff };

[[nodiscard]] std::optional<LogFormat> log_format_from(std::string_view name);  // "text", "json"
// "debug", "info", "warning", "error", "off"
[[nodiscard]] std::optional<LogLevel> log_level_from(std::string_view name);

struct LogOptions {
  LogFormat format = LogFormat::kText;
  LogLevel level = LogLevel::kInfo;
};

// Logs to standard error from this call on.
void start_log(const LogOptions& options);
// Returns the format of start_log(); text before.
[[nodiscard]] LogFormat log_format();
// Callable from any thread.
void set_log_level(LogLevel level);

using LogValue = std::variant<std::uint64_t, double, std::string_view>;
struct LogField {
  const char* name;
  std::optional<LogValue> value;  // Omitted if empty.
};

[[nodiscard]] bool is_logged(LogLevel level);
void log_line(LogLevel level, std::string_view text, std::initializer_list<LogField> fields);

// Logs a line that clients can cause at any rate. The lines per second are limited for each address
// and in total; the field `left_out` of the next line counts the omitted ones. `peer` is an address
// with or without a port.
void log_line_about(std::string_view peer, LogLevel level, std::string_view text,
                    std::initializer_list<LogField> fields);

// The formatters, for tests: each returns one line without its end.
[[nodiscard]] std::string text_fields(std::initializer_list<LogField> fields);
[[nodiscard]] std::string json_fields(std::initializer_list<LogField> fields);
[[nodiscard]] std::string escaped_for_text(std::string_view text);
[[nodiscard]] std::string json_quoted(std::string_view text);

}  // namespace multitetra
