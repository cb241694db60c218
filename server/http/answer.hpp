// The answer to one HTTP request, before it has become bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <variant>

#include "common/base/result.hpp"
#include "common/base/scratch_file.hpp"
#include "server/http/http_request.hpp"

namespace multitetra {

// Bytes that are made once and sent to many, without a copy.
using SharedBytes = std::shared_ptr<const std::string>;
// Bytes that lie on the disk, and are read a piece at a time.
using SharedFile = std::shared_ptr<const ScratchFile>;

// A file is sent in pieces of so many bytes, of which one is in memory.
inline constexpr std::uint64_t kFilePieceBytes = 256 * 1024;

// Some of the bytes of a whole.
struct Body {
  std::variant<std::string, SharedBytes, SharedFile> whole = {};
  std::uint64_t first = 0;
  std::uint64_t length = 0;
  bool is_resident = false;  // In memory for as long as the program runs, sent or not.
};
[[nodiscard]] Body body_of(std::string text);
[[nodiscard]] Body body_of(SharedBytes bytes);
[[nodiscard]] Body body_of(SharedFile file, std::uint64_t size);

struct Answer {
  int status = 200;
  std::string fields = {};  // Header fields, "Name: value\r\n" each.
  Body body = {};
  bool is_length_known = true;  // False only for an answer to HEAD whose body was never made.
};

// The memory that an answer takes until it has been sent. What it shares with a cache counts as
// well, since the cache may evict it before. 0 for resident bytes, and for a few bytes: those are
// part of the connection's memory.
[[nodiscard]] std::size_t memory_of(const Answer& answer);

// Adds a header field. `value` is ours or was checked: it has no line break.
void add_field(Answer& answer, std::string_view name, std::string_view value);

// "application/json", as it is.
[[nodiscard]] Answer json_answer(int status, std::string json);
// JSON that is requested often and seldom changes.
[[nodiscard]] Answer document_answer(std::string json, const HttpRequest& request);
// {"error":{"code","text","request_id"}}; such a response is not cacheable.
[[nodiscard]] Answer error_answer(int status, const Error& error, std::string_view request_id);
// The same with the status that the code stands for.
[[nodiscard]] Answer error_answer(const Error& error, std::string_view request_id);

// The ETag of some bytes, in quotes.
[[nodiscard]] std::string tag_of(std::string_view content);

// Applies the request's conditions and ranges to a complete response with status 200. `tag` is the
// entity tag of its content, in quotes, and is sent.
void apply_conditions(Answer& answer, const HttpRequest& request, std::string_view tag);

// The status line and the header. Contains the body's length also where no body follows, as for
// HEAD.
[[nodiscard]] std::string head_of(const Answer& answer, bool keep_alive);

}  // namespace multitetra
