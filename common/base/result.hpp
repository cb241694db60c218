// The outcome of an operation on bytes or words from outside: a value, or an error with a code and
// a text.
//
//   Result<Volume> volume = parse(bytes);
//   if (!volume) return tl::unexpected(volume.error());
//
// Three kinds of faults are handled in three ways: programming errors are asserted, untrusted input
// gives a Result, and the environment (disk, memory, ports) throws an exception that ends in main()
// or at a session's edge.
#pragma once

#include <string>
#include <string_view>
#include <utility>

#include <tl/expected.hpp>

namespace multitetra {

// The kind of error. The numbers are those of `ErrorCode` in proto/multitetra/v1: never
// renumber.
enum class ErrorCode {
  kUnknown = 0,
  kMalformedFrame = 1,      // The byte stream cannot be followed any more; the connection ends.
  kMessageTooLarge = 2,     // A frame longer than the receiver's limit; the connection ends.
  kMalformedMessage = 3,    // The frame is whole but is not a message we know; the connection ends.
  kUnsupportedVersion = 4,  // No protocol version in common.
  kUnexpectedMessage = 5,   // A message that has no place at this point of the conversation.
  kUnknownDataset = 6,      // No dataset of that name is served.
  kInvalidArgument =
      7,  // A value outside its documented range: NaN isovalue, negative threshold, ...
  kLimitExceeded = 8,  // A documented limit would be exceeded.
  kCancelled = 9,      // The stream was cancelled or superseded.
  kDamagedData = 10,   // Stored or sent bytes contradict their checksum, hash or counts.
  // A fault of the program; the text describes it.
  kInternal = 11,
  kUnavailable = 12,  // The server is going away or cannot be reached.
  // The server requires a token, or another one.
  kUnauthenticated = 13,
};

// The code's stable name in logs and JSON, for example "unknown_dataset".
[[nodiscard]] std::string_view name(ErrorCode code);

struct Error {
  ErrorCode code = ErrorCode::kUnknown;
  std::string text;        // One sentence: what was wrong, where, and what would be right.
  double retry_after = 0;  // Seconds after which to retry; 0: unknown.

  friend bool operator==(const Error&, const Error&) = default;
};

template <typename T>
using Result = tl::expected<T, Error>;

[[nodiscard]] inline tl::unexpected<Error> fail(ErrorCode code, std::string text) {
  return tl::unexpected<Error>(Error{code, std::move(text)});
}

}  // namespace multitetra
