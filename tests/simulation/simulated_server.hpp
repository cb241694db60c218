// A server whose conversations, streams and queue are the product's; its workers and its store are
// simulated. A job takes a random time, in pieces between which it may pause, and the store may
// fail.
#pragma once

#include <list>
#include <memory>
#include <utility>

#include "common/net/coroutines.hpp"
#include "common/net/frame.hpp"
#include "server/conversation/session_runner.hpp"
#include "server/service/detail/worker_jobs.hpp"
#include "server/service/fair_queue.hpp"
#include "server/store/store_error.hpp"
#include "server/stream/stream_messages.hpp"
#include "tests/simulation/world.hpp"

namespace multitetra::simulation {

// The datasets of all servers, which may be replaced, and their store.
struct Store {
  CataloguePtr catalogue;
  double failures = 0;  // The probability that a step cannot be read.
};

class SimulatedServer : public Peer {
 public:
  SimulatedServer(World& world, const Store& store, std::size_t workers)
      : world_(world), store_(store), workers_(workers), queue_(workers - 1) {}

  void accept(const LinkPtr& link) override;

  // What is left must be nothing when all clients have gone.
  [[nodiscard]] std::size_t streams() const { return streams_; }
  [[nodiscard]] std::size_t jobs() const { return queue_.waiting() + running_ + paused_.size(); }
  [[nodiscard]] std::size_t pauses() const { return pauses_; }
  [[nodiscard]] std::size_t most_jobs() const { return most_jobs_; }
  [[nodiscard]] std::size_t connections() const { return connections_; }

 private:
  class Client;
  class Stream;
  class Connection;

  void post(const FairQueue::Client& client, FairQueue::Job job) {
    queue_.add(client, std::move(job));
    most_jobs_ = std::max(most_jobs_, jobs());
    take();
  }
  // A job that has begun.
  struct Begun {
    FairQueue::DequeuedJob taken;
    double remaining = 0;
    double done = 0;
  };
  using BegunPtr = std::shared_ptr<Begun>;

  void take() {
    while (running_ < workers_) {
      auto taken = queue_.take();
      if (!taken) return;
      ++running_;
      const double seconds = taken->job.expected_seconds * world_.uniform(0.1, 3);
      run(std::make_shared<Begun>(Begun{*std::move(taken), seconds}));
    }
  }
  // Runs the next piece.
  void run(const BegunPtr& job) {
    const double piece = std::min(job->remaining, world_.uniform(0.01, 2));
    world_.after(piece, [this, job, piece] {
      job->remaining -= piece;
      job->done += piece;
      if (job->remaining > 0) return queue_.should_pause(job->taken) ? pause(job) : run(job);
      --running_;
      queue_.done(job->taken, job->done);
      job->taken.job.run();
      resume_due();
      take();
    });
  }
  void pause(const BegunPtr& job) {
    ++pauses_;
    --running_;
    queue_.paused(job->taken);
    paused_.push_back(job);
    resume_due();
    take();
    world_.after(2, [this, job] {
      if (std::count(paused_.begin(), paused_.end(), job) > 0) resume(job);
    });
  }
  void resume(const BegunPtr& job) {
    paused_.remove(job);
    ++running_;
    queue_.resumed(job->taken);
    run(job);
  }
  void resume_due() {
    for (const std::list<BegunPtr> all = paused_; const BegunPtr& job : all) {
      if (queue_.should_resume(job->taken)) resume(job);
    }
  }

  World& world_;
  const Store& store_;
  const std::size_t workers_;
  FairQueue queue_;
  AdmissionControl admission_{{.connections = {}, .requests = {.per_second = 1e9, .burst = 1e9}}};
  std::size_t running_ = 0;
  std::list<BegunPtr> paused_;
  std::size_t pauses_ = 0;
  std::size_t most_jobs_ = 0;
  std::size_t streams_ = 0;
  std::size_t connections_ = 0;
  std::uint64_t last_client_ = 0;
};

// The messages of one stream, whose steps are jobs of the server.
class SimulatedServer::Stream : public ProgressiveStream,
                                public std::enable_shared_from_this<Stream> {
 public:
  Stream(SimulatedServer& server, FairQueue::Client client, ValidatedStream action,
         std::function<void()> changed)
      : server_(server),
        client_(std::move(client)),
        action_(std::move(action)),
        messages_(action_.open, action_.source->info()),
        changed_(std::move(changed)) {
    ++server_.streams_;
  }
  ~Stream() override { --server_.streams_; }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  std::optional<ServerMessage> take() override {
    if (!messages_.has_message()) return std::nullopt;
    ServerMessage message = messages_.take();
    make_next_step();
    return message;
  }
  void end(StreamOutcome outcome) override {
    stop_.request_stop();
    messages_.end(outcome);
    changed_();
  }
  void fail(Error error) override {
    stop_.request_stop();
    messages_.fail(std::move(error));
    changed_();
  }
  void drop() override {
    stop_.request_stop();
    changed_ = [] {};
  }

  void make_next_step() {
    if (stop_.stop_requested()) return;
    const auto state = messages_.take_request();
    if (!state) return;
    const Work work = work_for(action_, *state, stop_.get_token());
    server_.post(
        client_,
        {.run = [self = shared_from_this(), state = *state] { self->make(state); },
         .is_long = work.is_long,
         .kind = work.kind,
         .expected_seconds = work.is_long ? (state->request.error < 1 ? 20.0 : 1.0) : 0.05});
  }

 private:
  void make(const StreamState& state) {
    if (stop_.stop_requested()) return;
    if (server_.world_.chance(server_.store_.failures)) {
      return fail({ErrorCode::kUnavailable, "The store does not answer.", 1.0});
    }
    // The plan depends on both; what has begun does not.
    const StepLimits limits{.bytes_per_second = std::pow(10, server_.world_.uniform(3.5, 7)),
                            .is_contended = server_.world_.chance(0.5)};
    auto made = make_steps(action_, state, messages_.dataset(), limits, stop_.get_token());
    if (!made) return fail(made.error());
    messages_.supply(std::move(made->front()), 0.1);
    changed_();
  }

  SimulatedServer& server_;
  const FairQueue::Client client_;
  const ValidatedStream action_;
  StreamMessages messages_;
  std::function<void()> changed_;
  std::stop_source stop_;
};

class SimulatedServer::Client : public ServiceClient {
 public:
  Client(SimulatedServer& server, ConnectionContextPtr client)
      : ServiceClient(std::move(client), {}), server_(server), number_(++server.last_client_) {}

  CataloguePtr catalogue() const override { return server_.store_.catalogue; }
  ProgressiveStreamPtr steps(ValidatedStream action, std::function<void()> changed) override {
    const FairQueue::Client in_queue{.share = client()->quota_key(), .number = number_};
    const auto stream =
        std::make_shared<Stream>(server_, in_queue, std::move(action), std::move(changed));
    stream->make_next_step();
    return stream;
  }
  void answer(ValidatedQuery, std::stop_token, UseReply, QueryDone done) override {
    done(multitetra::fail(ErrorCode::kInternal, "No client asks this."));
  }
  void enforce_limits(std::chrono::steady_clock::time_point) override {}

 protected:
  void make_surface(ValidatedStream, std::uint64_t, std::string, std::stop_token, UseSurface,
                    std::function<void(Result<void>)>) override {}

 private:
  SimulatedServer& server_;
  const std::uint64_t number_;
};

// Takes the place of the transport between a link and the product's conversation.
class SimulatedServer::Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(SimulatedServer& server, LinkPtr link)
      : server_(server), link_(std::move(link)), room_(server.world_.io().get_executor()) {
    const auto executor = server.world_.io().get_executor();
    const std::string address = "10.0." + std::to_string(server.last_client_ / 250 % 250) + "." +
                                std::to_string(1 + server.last_client_ % 250);
    const auto client = server.admission_.admit("tcp", address, address + ":1").client;
    const auto service = std::make_shared<Client>(server, client);
    runner_ = std::make_shared<SessionRunner>(
        executor, service,
        Session(service->catalogue(), {}, nullptr, [service] { return service->catalogue(); }),
        client);
    ++server_.connections_;
  }
  ~Connection() { --server_.connections_; }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void start() {
    link_->end(1) = {.received = [self = shared_from_this()](std::string_view b) { self->feed(b); },
                     .closed = [self = shared_from_this()] { self->lost(); },
                     .has_room = [self = shared_from_this()] { self->room_.notify_all(); }};
    const auto executor = server_.world_.io().get_executor();
    spawn(executor, [self = shared_from_this()] { return self->write(); });
    spawn(executor, [self = shared_from_this()] { return self->read(); });
  }

 private:
  void feed(std::string_view bytes) {
    reader_.feed(bytes);
    room_.notify_all();
  }
  void lost() {
    is_lost_ = true;
    runner_->on_disconnect();
    room_.notify_all();
  }
  asio::awaitable<void> read() {
    const auto self = shared_from_this();
    while (!is_lost_) {
      co_await runner_->until_readable();
      auto content = reader_.next();
      if (!content) {
        runner_->end(content.error());
        break;
      }
      if (*content) {
        runner_->receive(**content);
      } else {
        co_await room_.wait();
      }
    }
  }
  asio::awaitable<void> write() {
    const auto self = shared_from_this();
    while (const auto message = co_await runner_->next_message()) {
      while (!is_lost_ && !link_->has_room(1)) co_await room_.wait();
      const std::string content = serialize(*message);
      link_->send(1, frame_header(static_cast<std::uint32_t>(content.size())) + content);
    }
    link_->close(1);
  }

  SimulatedServer& server_;
  const LinkPtr link_;
  FrameReader reader_{kMaxClientFrameBytes};
  std::shared_ptr<SessionRunner> runner_;
  AsyncEvent room_;  // Bytes have arrived, or left, or the link is lost.
  bool is_lost_ = false;
};

inline void SimulatedServer::accept(const LinkPtr& link) {
  std::make_shared<Connection>(*this, link)->start();
}

}  // namespace multitetra::simulation
