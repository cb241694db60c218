// Protobuf messages as bytes and back, without trust in the bytes.
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

// Counts the occurrences in a message's bytes of the field at the end of `path`, field numbers from
// the outermost message to the innermost, also where they name a message on the way several times:
// the parser merges those. An empty message costs the parser about 100 times its two bytes, so they
// are counted before it runs. Of bytes that are no message it counts what can be followed.
[[nodiscard]] std::size_t count_entries(std::string_view bytes, std::initializer_list<int> path);

// The number that the bytes of a message give last for the field at the end of `path`; 0 when none.
[[nodiscard]] std::uint64_t last_number(std::string_view bytes, std::initializer_list<int> path);

// From now on protobuf writes no line on stderr for strings that are not UTF-8: a way for clients
// to fill our log.
void silence_protobuf_log();

// False when the bytes are no `Wire`.
template <typename Wire>
[[nodiscard]] bool parse(std::string_view bytes, Wire& wire) {
  silence_protobuf_log();
  return bytes.size() <= static_cast<std::size_t>(std::numeric_limits<int>::max()) &&
         wire.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()));
}

[[nodiscard]] tl::unexpected<ParseError> refuse(ErrorCode code, std::string text,
                                                std::uint64_t request_id = 0);

[[nodiscard]] std::string not_a_message(std::string_view whose, std::size_t bytes);

// The message, unless a check failed.
template <typename Message>
[[nodiscard]] tl::expected<Message, ParseError> outcome(Message message, const FieldChecks& checks,
                                                        std::uint64_t request_id) {
  if (checks.first()) return refuse(checks.first()->code, checks.first()->text, request_id);
  return message;
}

}  // namespace multitetra::wire
