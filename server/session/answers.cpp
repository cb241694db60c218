#include "server/session/answers.hpp"

#include <variant>

namespace multitetra {

std::uint64_t request_id_of(const ServerMessage& message) {
  return std::visit(
      [](const auto& m) -> std::uint64_t {
        if constexpr (requires { m.request_id; }) {
          return m.request_id;
        } else {
          return 0;
        }
      },
      message);
}

bool is_shutdown_notice(const ServerMessage& message) {
  if (const auto* end = std::get_if<StreamEnd>(&message)) {
    return end->outcome != StreamOutcome::kComplete;
  }
  const auto* error = std::get_if<ErrorReply>(&message);
  return error && error->error.code == ErrorCode::kUnavailable;
}

bool is_last(const ServerMessage& message) {
  return std::holds_alternative<StreamEnd>(message) || std::holds_alternative<ErrorReply>(message);
}

std::string_view outcome_of(const ServerMessage& last) {
  if (const auto* error = std::get_if<ErrorReply>(&last)) return name(error->error.code);
  switch (std::get<StreamEnd>(last).outcome) {
    case StreamOutcome::kComplete:
      return "complete";
    case StreamOutcome::kCancelled:
      return "cancelled";
    case StreamOutcome::kSuperseded:
      return "superseded";
  }
  return "complete";
}

}  // namespace multitetra
