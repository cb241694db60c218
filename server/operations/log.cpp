#include "server/operations/log.hpp"

#include <atomic>
#include <charconv>
#include <chrono>
#include <cmath>
#include <memory>
#include <mutex>

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include "common/base/enum_names.hpp"
#include "common/base/json.hpp"
#include "server/operations/detail/log_sampling.hpp"
#include "server/operations/secrets.hpp"

namespace multitetra {
namespace {

// The field format. Atomic, as many threads write lines.
std::atomic<LogFormat> format_now = LogFormat::kText;

// In JSON, a pair of these encloses the fields before the text; field values are escaped.
constexpr char kFieldsMark = '\x1f';

std::string_view view_of(const spdlog::string_view_t& payload) {
  return {payload.data(), payload.size()};
}

template <typename Buffer>
void append(Buffer& buffer, std::string_view text) {
  buffer.append(text.data(), text.data() + text.size());
}

class EscapedText : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm&,
              spdlog::memory_buf_t& line) override {
    append(line, escaped_for_text(view_of(message.payload)));
  }
  [[nodiscard]] std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<EscapedText>();
  }
};

class JsonText : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm&,
              spdlog::memory_buf_t& line) override {
    std::string_view text = view_of(message.payload);
    std::string_view fields;
    if (text.starts_with(kFieldsMark)) {
      const std::size_t end = text.find(kFieldsMark, 1);
      fields = text.substr(1, end - 1);
      text = text.substr(end + 1);
    }
    append(line, json_quoted(text));
    append(line, fields);
  }
  [[nodiscard]] std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<JsonText>();
  }
};

std::unique_ptr<spdlog::formatter> formatter_of(LogFormat format) {
  if (format == LogFormat::kText) {
    auto lines = std::make_unique<spdlog::pattern_formatter>();
    lines->add_flag<EscapedText>('*').set_pattern("%Y-%m-%d %H:%M:%S.%e %l %*");
    return lines;
  }
  auto lines = std::make_unique<spdlog::pattern_formatter>(spdlog::pattern_time_type::utc);
  lines->add_flag<JsonText>('*').set_pattern(
      R"({"time":"%Y-%m-%dT%H:%M:%S.%fZ","level":"%l","text":%*})");
  return lines;
}

spdlog::level::level_enum level_of(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug:
      return spdlog::level::debug;
    case LogLevel::kInfo:
      return spdlog::level::info;
    case LogLevel::kWarning:
      return spdlog::level::warn;
    case LogLevel::kError:
      return spdlog::level::err;
    case LogLevel::kOff:
      break;
  }
  return spdlog::level::off;
}

// Six digits are enough for times and isovalues. JSON has no NaN or infinity.
std::string number(double value) {
  if (!std::isfinite(value)) return "null";
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value,
                                 std::chars_format::general, 6);
  return {digits.data(), end.ptr};
}

std::string text_value(const LogValue& value) {
  if (const auto* whole = std::get_if<std::uint64_t>(&value)) return std::to_string(*whole);
  if (const auto* real = std::get_if<double>(&value)) return number(*real);
  const std::string text = without_secrets(std::get<std::string_view>(value));
  const bool is_word = !text.empty() && text.find_first_of(" =\"\\") == std::string_view::npos;
  return is_word ? text : json_quoted(text);
}

std::string json_value(const LogValue& value) {
  if (const auto* text = std::get_if<std::string_view>(&value)) {
    return json_quoted(without_secrets(*text));
  }
  return text_value(value);
}

std::string in_format(std::initializer_list<LogField> fields) {
  return format_now == LogFormat::kText ? text_fields(fields) : json_fields(fields);
}

void write(LogLevel level, std::string_view text, const std::string& fields) {
  const std::string payload = format_now == LogFormat::kText
                                  ? without_secrets(text) + fields
                                  : kFieldsMark + fields + kFieldsMark + without_secrets(text);
  spdlog::default_logger_raw()->log(level_of(level), spdlog::string_view_t(payload));
}

class SharedSampler {
 public:
  [[nodiscard]] std::optional<std::uint64_t> admit(std::string_view peer) {
    const std::chrono::duration<double> now = std::chrono::steady_clock::now().time_since_epoch();
    const std::lock_guard lock(mutex_);
    return sampler_.admit(std::string(peer.substr(0, peer.rfind(':'))), now.count());
  }

 private:
  std::mutex mutex_;  // Guards sampler_.
  LogSampler sampler_;
};

SharedSampler& lines_about_clients() {
  static SharedSampler sampler;
  return sampler;
}

}  // namespace

std::optional<LogFormat> log_format_from(std::string_view name) {
  return EnumNames<LogFormat, 2>{{"text", "json"}}.find(name);
}

std::optional<LogLevel> log_level_from(std::string_view name) {
  return EnumNames<LogLevel, 5>{{"debug", "info", "warning", "error", "off"}}.find(name);
}

void start_log(const LogOptions& options) {
  format_now = options.format;
  auto logger = std::make_shared<spdlog::logger>("multitetra-server",
                                                 std::make_shared<spdlog::sinks::stderr_sink_mt>());
  logger->set_formatter(formatter_of(options.format));
  logger->set_level(level_of(options.level));
  spdlog::set_default_logger(std::move(logger));
}

LogFormat log_format() { return format_now; }

void set_log_level(LogLevel level) { spdlog::set_level(level_of(level)); }

bool is_logged(LogLevel level) { return spdlog::default_logger_raw()->should_log(level_of(level)); }

void log_line(LogLevel level, std::string_view text, std::initializer_list<LogField> fields) {
  if (is_logged(level)) write(level, text, in_format(fields));
}

void log_line_about(std::string_view peer, LogLevel level, std::string_view text,
                    std::initializer_list<LogField> fields) {
  if (!is_logged(level)) return;
  const auto left_out = lines_about_clients().admit(peer);
  if (!left_out) return;
  const std::string more = *left_out == 0 ? "" : in_format({{"left_out", *left_out}});
  write(level, text, in_format(fields) + more);
}

std::string text_fields(std::initializer_list<LogField> fields) {
  std::string text;
  for (const LogField& field : fields) {
    if (field.value) text += std::string(" ") + field.name + "=" + text_value(*field.value);
  }
  return text;
}

std::string json_fields(std::initializer_list<LogField> fields) {
  std::string text;
  for (const LogField& field : fields) {
    if (field.value) text += std::string(",\"") + field.name + "\":" + json_value(*field.value);
  }
  return text;
}

std::string escaped_for_text(std::string_view text) {
  constexpr std::string_view kHexDigits = "0123456789abcdef";
  std::string escaped;
  escaped.reserve(text.size());
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x20 && byte != 0x7f) {
      escaped += c;
    } else {
      escaped += "\\x";
      escaped += kHexDigits[byte / 16];
      escaped += kHexDigits[byte % 16];
    }
  }
  return escaped;
}

std::string json_quoted(std::string_view text) { return json_text(nlohmann::json(text)); }

}  // namespace multitetra
