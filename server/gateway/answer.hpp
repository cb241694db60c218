// The answer to one HTTP request, before it has become bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <variant>

#include "common/result.hpp"

namespace multitetra {

// Bytes that are made once and sent to many, without a copy.
using SharedBytes = std::shared_ptr<const std::string>;

struct Answer {
  int status = 200;
  std::string fields = {};  // Header fields, "Name: value\r\n" each.
  std::variant<std::string, SharedBytes> body = {};

  [[nodiscard]] std::size_t body_bytes() const;
};

// Adds a header field.
void add_field(Answer& answer, std::string_view name, std::string_view value);

// "application/json" with a trailing newline.
[[nodiscard]] Answer json_answer(int status, std::string json);
// {"error":{"code","text","request_id"}}; such an answer is stored by nobody.
[[nodiscard]] Answer error_answer(int status, const Error& error, std::string_view request_id);

// The status line and the header. The body's length is told also where no body follows, as to HEAD.
[[nodiscard]] std::string head_of(const Answer& answer, bool keep_alive);

}  // namespace multitetra
