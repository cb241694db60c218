// Answers that the workers of this process make.
//
// A step is made only when the messages of the one before have gone. At most one step of a session
// is with the workers, also when streams supersede each other. Workers never wait for a client, and
// touch only what makes the step; everything else happens on the executor's thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>

#include "server/operations/admission_control.hpp"
#include "server/stream/stream_plan.hpp"
#include "server/stream/workers.hpp"
#include "server/transport/session_backend.hpp"
#include "server/transport/session_limits.hpp"

namespace multitetra {

class WorkerBackend : public SessionBackend, public std::enable_shared_from_this<WorkerBackend> {
 public:
  using Clock = std::chrono::steady_clock;

  // The workers must live until their work is done, the client's admission control as long as this.
  WorkerBackend(asio::any_io_executor executor, Workers& workers, ClientContextPtr client,
                const SessionLimits& limits);
  ~WorkerBackend() override;

  [[nodiscard]] std::optional<asio::awaitable<Found>> find_catalogue(std::string) override {
    return std::nullopt;
  }
  [[nodiscard]] BackendStreamPtr start(StartStream action, std::function<void()> changed) override;
  void answer(AnswerQuestion action, std::stop_token stop,
              std::function<void(Result<QuestionReply>)> done) override;
  void link_carries(double bytes_per_second) override { bytes_per_second_ = bytes_per_second; }
  void keep_time(Clock::time_point now) override;
  void close() override {}

 private:
  class Stream;
  using StreamPtr = std::shared_ptr<Stream>;
  struct QuestionJob;
  using QuestionPtr = std::shared_ptr<QuestionJob>;

  // Unless one is being made: step_made() calls it again then.
  void make_next_step();
  [[nodiscard]] FairQueue::Client queue_client() const;
  // Why no more may wait, if so.
  [[nodiscard]] std::optional<Error> check_backlog();
  // A worker begins with it: from now on its time counts.
  void step_begins(const StreamPtr& stream);
  void step_made(const StreamPtr& stream, Result<MadeStep> step, double seconds);
  void answer_made(const QuestionPtr& job, Result<QuestionReply> made);

  asio::any_io_executor executor_;
  Workers& workers_;
  std::uint64_t queue_number_;
  ClientContextPtr client_;
  SessionLimits limits_;
  double bytes_per_second_ = kUsualBytesPerSecond;  // Of the way to the client.
  StreamPtr stream_;                                // Null when none runs.
  std::set<QuestionPtr> questions_;
  bool is_making_ = false;  // A step is with the workers: of stream_, or of one that was stopped.
};

}  // namespace multitetra
