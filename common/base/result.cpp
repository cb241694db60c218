#include "common/base/result.hpp"

namespace multitetra {

std::string_view name(ErrorCode code) {
  switch (code) {
    case ErrorCode::kUnknown:
      return "unknown";
    case ErrorCode::kMalformedFrame:
      return "malformed_frame";
    case ErrorCode::kMessageTooLarge:
      return "message_too_large";
    case ErrorCode::kMalformedMessage:
      return "malformed_message";
    case ErrorCode::kUnsupportedVersion:
      return "unsupported_version";
    case ErrorCode::kUnexpectedMessage:
      return "unexpected_message";
    case ErrorCode::kUnknownDataset:
      return "unknown_dataset";
    case ErrorCode::kInvalidArgument:
      return "invalid_argument";
    case ErrorCode::kLimitExceeded:
      return "limit_exceeded";
    case ErrorCode::kCancelled:
      return "cancelled";
    case ErrorCode::kDamagedData:
      return "damaged_data";
    case ErrorCode::kInternal:
      return "internal";
    case ErrorCode::kUnavailable:
      return "unavailable";
    case ErrorCode::kUnauthenticated:
      return "unauthenticated";
    case ErrorCode::kPermissionDenied:
      return "permission_denied";
  }
  return "unknown";
}

}  // namespace multitetra
