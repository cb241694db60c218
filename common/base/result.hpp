// The result of an operation on untrusted input: a value, or an error with a code and a text.
//
//   Result<Volume> volume = parse(bytes);
//   if (!volume) return tl::unexpected(volume.error());
//
// Faults are handled in three ways: programming errors are asserted, untrusted input gives a
// Result, and failures of the environment (disk, memory, ports) throw an exception that is caught
// in main() or at the edge of a session.
#pragma once

#include <string>
#include <string_view>
#include <utility>

#include <tl/expected.hpp>

namespace multitetra {

// The numbers equal those of `ErrorCode` in proto/multitetra/v1 and must never change.
enum class ErrorCode {
  kUnknown = 0,
  kMalformedFrame = 1,      // The framing of the byte stream is broken; ends the connection.
  kMessageTooLarge = 2,     // A frame exceeds the receiver's limit; ends the connection.
  kMalformedMessage = 3,    // Not a valid message; ends the connection.
  kUnsupportedVersion = 4,  // No common protocol version.
  kUnexpectedMessage = 5,   // Not allowed at this point of the conversation.
  kUnknownDataset = 6,      // The server has no dataset of that name.
  // A value outside its documented range: NaN isovalue, negative threshold, ...
  kInvalidArgument = 7,
  kLimitExceeded = 8,  // A documented limit would be exceeded.
  kCancelled = 9,      // The stream was cancelled or superseded.
  kDamagedData = 10,   // Bytes contradict their checksum, digest or counts.
  // A fault of the program; the text describes it.
  kInternal = 11,
  kUnavailable = 12,  // The server is stopping, overloaded or unreachable.
  // The token is missing or invalid.
  kUnauthenticated = 13,
  kPermissionDenied = 14,  // The client may not receive this, such as samples.
};

// Returns the code's stable name in logs and JSON, such as "unknown_dataset".
[[nodiscard]] std::string_view name(ErrorCode code);

struct Error {
  ErrorCode code = ErrorCode::kUnknown;
  std::string text;        // One sentence: what is wrong, where, and what is expected.
  double retry_after = 0;  // Seconds after which to retry; 0: unknown.

  friend bool operator==(const Error&, const Error&) = default;
};

template <typename T>
using Result = tl::expected<T, Error>;

[[nodiscard]] inline tl::unexpected<Error> fail(ErrorCode code, std::string text) {
  return tl::unexpected<Error>(Error{code, std::move(text)});
}

}  // namespace multitetra
