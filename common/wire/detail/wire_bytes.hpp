// Serializes protobuf messages, and parses untrusted ones.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "common/wire/detail/wire_checks.hpp"
#include "common/wire/messages.hpp"

namespace multitetra::wire {

// Returns the number of occurrences of a field in a message's bytes. `path` lists field numbers
// from the outermost message to the innermost. Includes repeated occurrences of a submessage, which
// the parser merges. Checked before parsing, since an empty message of two bytes costs the parser
// about 100 times that. In malformed bytes, counts until the fault.
[[nodiscard]] std::size_t count_entries(std::string_view bytes, std::initializer_list<int> path);

// Returns the last value of the integer field at the end of `path`; 0 if there is none.
[[nodiscard]] std::uint64_t last_number(std::string_view bytes, std::initializer_list<int> path);

// Stops protobuf from reporting invalid UTF-8 on stderr, with which clients could fill our log.
void silence_protobuf_log();

// Returns false if the bytes are not a valid `Wire`.
template <typename Wire>
[[nodiscard]] bool parse(std::string_view bytes, Wire& wire) {
  silence_protobuf_log();
  return bytes.size() <= static_cast<std::size_t>(std::numeric_limits<int>::max()) &&
         wire.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()));
}

[[nodiscard]] tl::unexpected<ParseError> refuse(ErrorCode code, std::string text,
                                                std::uint64_t request_id = 0);

[[nodiscard]] std::string not_a_message(std::string_view whose, std::size_t bytes);

// Returns the message, or the first fault if a check failed.
template <typename Message>
[[nodiscard]] tl::expected<Message, ParseError> outcome(Message message, const FieldChecks& checks,
                                                        std::uint64_t request_id) {
  if (checks.first()) return refuse(checks.first()->code, checks.first()->text, request_id);
  return message;
}

}  // namespace multitetra::wire
