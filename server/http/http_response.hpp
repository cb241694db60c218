// The answer to one HTTP request, before serialization.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "common/base/result.hpp"
#include "common/base/scratch_file.hpp"
#include "server/http/http_request.hpp"

namespace multitetra {

// Immutable bytes, shared by many answers without a copy.
using SharedBytes = std::shared_ptr<const std::string>;
// Bytes on disk, read piecewise.
using SharedFile = std::shared_ptr<const ScratchFile>;

// The size of the pieces in which files are sent; one is in memory at a time.
inline constexpr std::uint64_t kFilePieceBytes = 256 * 1024;

// A range of some content.
struct Body {
  std::variant<std::string, SharedBytes, SharedFile> whole = {};
  std::uint64_t first = 0;
  std::uint64_t length = 0;
  // The bytes stay in memory for the lifetime of the program.
  bool is_resident = false;
};
[[nodiscard]] Body body_of(std::string text);
[[nodiscard]] Body body_of(SharedBytes bytes);
[[nodiscard]] Body body_of(SharedFile file, std::uint64_t size);

struct HttpResponse {
  int status = 200;
  std::string fields = {};  // "Name: value\r\n" for each header field.
  Body body = {};
  bool is_length_known = true;      // False only for HEAD if the body was never made.
  std::optional<Error> error = {};  // Set by error_answer(), for the log.
};

// Returns the name of the error's code, or "complete".
[[nodiscard]] std::string_view outcome_of(const HttpResponse& response);

// Returns the memory to reserve until an answer has been sent. Includes bytes shared with a cache,
// since the cache may evict them earlier. Returns 0 for resident bytes, and for a few bytes, which
// are part of the connection's memory.
[[nodiscard]] std::size_t memory_of(const HttpResponse& response);

// Adds a header field. `value` must not contain a line break.
void add_field(HttpResponse& response, std::string_view name, std::string_view value);

// Returns `json` as "application/json".
[[nodiscard]] HttpResponse json_answer(int status, std::string json);
// Returns the answer for JSON that is requested often and rarely changes.
[[nodiscard]] HttpResponse document_answer(std::string json, const HttpRequest& request);
// Returns {"error":{"code","text","request_id"}}, not cacheable.
[[nodiscard]] HttpResponse error_answer(int status, const Error& error,
                                        std::string_view request_id);
// Uses the status that corresponds to the error's code.
[[nodiscard]] HttpResponse error_answer(const Error& error, std::string_view request_id);

// Returns the ETag of some bytes, in quotes.
[[nodiscard]] std::string tag_of(std::string_view content);

// Returns whether a response needs its body: not for HEAD, nor if the client's copy is current. An
// empty `tag` stands for content that is not known before it is made.
[[nodiscard]] bool needs_body(const HttpRequest& request, std::string_view tag);

// Applies the request's conditions and ranges to a complete response of status 200, and adds `tag`,
// the quoted entity tag of its content.
void apply_conditions(HttpResponse& response, const HttpRequest& request, std::string_view tag);

// Returns the status line and the header. Content-Length is present even without a body,
// as for HEAD.
[[nodiscard]] std::string head_of(const HttpResponse& response, bool keep_alive);

}  // namespace multitetra
