// A conversation that is held for a single HTTP request: whatever is answered there went through a
// Dialogue, with its rights and its limits.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/messages.hpp"
#include "common/net.hpp"
#include "server/gateway/visit.hpp"

namespace multitetra {

class Inquiry {
 public:
  // Holds `dialogue` in the visit until its own end.
  Inquiry(DialoguePtr dialogue, Visit& visit);
  ~Inquiry();
  Inquiry(const Inquiry&) = delete;
  Inquiry& operator=(const Inquiry&) = delete;

  // Says Hello. First and once.
  [[nodiscard]] asio::awaitable<Result<void>> greet(std::string token);
  [[nodiscard]] asio::awaitable<Result<std::vector<DatasetInfo>>> datasets();

  // A final step, encoded.
  struct Step {
    StepBegin begin;
    std::vector<std::shared_ptr<const std::string>> payloads;  // As in begin.tiles.
    StepEnd end;
  };
  // kLimitExceeded for a step of more than `max_triangles`, as soon as it is known.
  [[nodiscard]] asio::awaitable<Result<Step>> final_step(std::string dataset,
                                                         IsosurfaceRequest request,
                                                         std::uint64_t max_triangles);

 private:
  // The next message; what ends the conversation is an error.
  [[nodiscard]] asio::awaitable<Result<ServerMessage>> next();
  // The next message, which must be an M.
  template <typename M>
  [[nodiscard]] asio::awaitable<Result<M>> next_a();
  void say(const ClientMessage& message);

  DialoguePtr dialogue_;
  Visit& visit_;
};

}  // namespace multitetra
