// A conversation that is held for a single HTTP request: whatever is answered there went through a
// StreamSession, with its rights and its limits.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/net/net.hpp"
#include "common/wire/messages.hpp"
#include "server/http/request_context.hpp"

namespace multitetra {

// Of all its tiles together.
[[nodiscard]] std::uint64_t triangles_of(const StepBegin& step);

class OneShotSession {
 public:
  // Holds `session` in the context until its own end.
  OneShotSession(StreamSessionPtr session, RequestContext& context);
  ~OneShotSession();
  OneShotSession(const OneShotSession&) = delete;
  OneShotSession& operator=(const OneShotSession&) = delete;

  // Says Hello. First and once.
  [[nodiscard]] asio::awaitable<Result<void>> greet(std::string token);
  [[nodiscard]] asio::awaitable<Result<std::vector<DatasetInfo>>> datasets();

  // One of them; kUnknownDataset where there is none of that name.
  [[nodiscard]] asio::awaitable<Result<DatasetInfo>> dataset(std::string name);
  [[nodiscard]] asio::awaitable<Result<SliceReply>> slice(std::string dataset, SliceRequest slice);
  [[nodiscard]] asio::awaitable<Result<ProbeReply>> probe(std::string dataset, ProbeRequest probe);

  // A final step, encoded.
  struct Step {
    StepBegin begin;
    std::vector<std::shared_ptr<const std::string>> payloads;  // As in begin.tiles,
    std::vector<std::shared_ptr<const std::string>> scalars;   // and their codes, if asked for.
    StepEnd end;
  };
  // kLimitExceeded for a step of more than `max_triangles`, as soon as it is known.
  [[nodiscard]] asio::awaitable<Result<Step>> final_step(std::string dataset,
                                                         IsosurfaceRequest request,
                                                         std::uint64_t max_triangles,
                                                         std::optional<ScalarRequest> scalars = {});
  [[nodiscard]] asio::awaitable<Result<EstimateReply>> estimate(std::string dataset,
                                                                IsosurfaceRequest request);

 private:
  // The next message; what ends the conversation is an error.
  [[nodiscard]] asio::awaitable<Result<ServerMessage>> next();
  // The next message, which must be an M.
  template <typename M>
  [[nodiscard]] asio::awaitable<Result<M>> next_a();
  void say(const ClientMessage& message);

  StreamSessionPtr session_;
  RequestContext& context_;
  std::uint64_t last_stream_ = 0;  // The id of the stream that was opened last.
};

}  // namespace multitetra
