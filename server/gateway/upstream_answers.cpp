#include "server/gateway/upstream_answers.hpp"

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

bool is_about_stopping(const ServerMessage& message) {
  if (const auto* end = std::get_if<StreamEnd>(&message)) {
    return end->outcome != StreamOutcome::kComplete;
  }
  const auto* error = std::get_if<ErrorReply>(&message);
  return error && error->error.code == ErrorCode::kUnavailable;
}

bool is_last(const ServerMessage& message) {
  return std::holds_alternative<StreamEnd>(message) || std::holds_alternative<ErrorReply>(message);
}

}  // namespace multitetra
