// Answers that other servers make. What there is for a client is what they offer together; streams
// and questions are passed on. When a server is lost in the middle of a stream, another one that
// has the same dataset is asked the same, and the client notices nothing but a pause.
//
// Memory is bounded: a few messages wait for the client, and what comes behind them waits in the
// socket of the server that sends it.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "common/net/async_event.hpp"
#include "server/gateway/upstream_pool.hpp"
#include "server/gateway/upstream_questions.hpp"
#include "server/operations/admission_control.hpp"
#include "server/transport/session_backend.hpp"

namespace multitetra {

class UpstreamBackend : public SessionBackend,
                        public std::enable_shared_from_this<UpstreamBackend> {
 public:
  UpstreamBackend(asio::any_io_executor executor, std::shared_ptr<UpstreamPool> upstreams,
                  ClientContextPtr client);
  ~UpstreamBackend() override;

  [[nodiscard]] std::optional<asio::awaitable<Found>> find_catalogue(std::string token) override;
  [[nodiscard]] BackendStreamPtr start(StartStream action, std::function<void()> changed) override;
  void answer(AnswerQuestion action, std::stop_token stop,
              std::function<void(Result<QuestionReply>)> done) override;
  void keep_time(std::chrono::steady_clock::time_point) override {}
  void close() override;

 private:
  class Stream;
  using StreamPtr = std::shared_ptr<Stream>;

  // Brings all streams, one after the other, until it is closed.
  asio::awaitable<void> bring_streams();
  asio::awaitable<void> bring(StreamPtr stream);
  // Makes sure that reached_ is a holder of its dataset; false when the stream cannot go on.
  asio::awaitable<bool> reach_holder(StreamPtr stream);
  // Until the stream is over (true) or the server lost (false).
  asio::awaitable<bool> forward(StreamPtr stream);
  void take(const StreamPtr& stream, ServerMessage message);
  void cancel(Stream& stream);
  [[nodiscard]] UpstreamClient upstream_client() const;
  asio::awaitable<void> bring_answer(AnswerQuestion action,
                                     std::function<void(Result<QuestionReply>)> done);

  asio::any_io_executor executor_;
  std::shared_ptr<UpstreamPool> upstreams_;
  UpstreamQuestions questions_;
  ClientContextPtr client_;
  std::string token_;
  bool is_closed_ = false;
  bool is_bringing_ = false;
  StreamPtr stream_;                              // Null when none runs.
  std::optional<UpstreamPool::Reached> reached_;  // Of the last stream, for the next.
  AsyncEvent change_;
};

}  // namespace multitetra
