#include "server/service/local_service.hpp"

#include <set>
#include <utility>
#include <vector>

#include "common/net/coroutines.hpp"
#include "server/service/detail/worker_jobs.hpp"
#include "server/stream/stream_messages.hpp"

namespace multitetra {
namespace {

class LocalServiceClient : public ServiceClient,
                           public std::enable_shared_from_this<LocalServiceClient> {
 public:
  LocalServiceClient(LocalService& service, ConnectionContextPtr client)
      : ServiceClient(std::move(client), service.options().requests),
        service_(service),
        queue_number_(service.workers().new_client()) {}

  CataloguePtr catalogue() const override { return service_.catalogue(); }
  ProgressiveStreamPtr steps(ValidatedStream action, std::function<void()> changed) override;
  void answer(ValidatedQuery action, std::stop_token stop, UseReply use, QueryDone done) override;
  void set_bandwidth(double bytes_per_second) override { bytes_per_second_ = bytes_per_second; }
  void enforce_limits(Clock::time_point now) override;

 protected:
  void make_surface(ValidatedStream action, std::uint64_t max_triangles, std::string what,
                    std::stop_token stop, UseSurface use,
                    std::function<void(Result<void>)> done) override;

 private:
  class Stream;
  using StreamPtr = std::shared_ptr<Stream>;

  // A query or surface that is computed in one job.
  struct Job {
    explicit Job(std::stop_token left) : leave(std::move(left), [this] { stop.request_stop(); }) {}
    std::stop_source stop;
    const std::shared_ptr<WorkTime> time = std::make_shared<WorkTime>();
    bool is_late = false;
    std::stop_callback<std::function<void()>> leave;
  };
  using JobPtr = std::shared_ptr<Job>;
  // Runs `make(stop)`, which must not throw, on a worker, and then `done(result, seconds)` here.
  template <typename T>
  void run(Work work, std::stop_token left, std::function<Result<T>(const std::stop_token&)> make,
           std::function<void(Result<T>, double seconds)> done);

  // Does nothing while a step is being made; steps_made() then calls it again.
  void make_next_step();
  [[nodiscard]] FairQueue::Client in_queue() const {
    return {.share = client()->quota_key(), .number = queue_number_};
  }
  // Returns an error if the share has too much pending work.
  [[nodiscard]] std::optional<Error> check_backlog();
  [[nodiscard]] StepLimits step_limits() const;
  // Whether a request has taken more of the workers' time than one may.
  [[nodiscard]] bool is_above_limit(double seconds) const;
  void steps_made(const StreamPtr& stream, Result<std::vector<StepResult>> steps, double seconds);

  LocalService& service_;
  std::uint64_t queue_number_;
  double bytes_per_second_ = kDefaultBytesPerSecond;
  StreamPtr stream_;  // Null if none runs.
  std::set<JobPtr> jobs_;
  // A worker has a step of stream_ or of a stopped stream.
  bool is_making_ = false;
};

// Shared with workers, which use only `action` and `stop`.
class LocalServiceClient::Stream : public ProgressiveStream {
 public:
  Stream(std::weak_ptr<LocalServiceClient> service_client, ValidatedStream started,
         std::function<void()> changed)
      : messages(started.open, started.source->info(), range_of(started), started.shells),
        action(std::move(started)),
        changed_(std::move(changed)),
        service_client_(std::move(service_client)) {}

  std::optional<ServerMessage> take() override {
    if (!messages.has_message()) return std::nullopt;
    ServerMessage message = messages.take();
    const auto service_client = service_client_.lock();
    if (service_client && service_client->stream_.get() == this) service_client->make_next_step();
    return message;
  }
  void end(StreamOutcome outcome) override {
    stop.request_stop();
    messages.end(outcome);
    changed_();
  }
  void fail(Error error) override {
    stop.request_stop();
    messages.fail(std::move(error));
    changed_();
  }
  // A worker may still hold the stream, so releases what it has reserved.
  void drop() override {
    stop.request_stop();
    memory = {};
    const auto service_client = service_client_.lock();
    if (service_client && service_client->stream_.get() == this) service_client->stream_.reset();
  }
  // Fails before the client has received anything of the stream.
  void refuse(Error error) { messages.fail(std::move(error)); }
  void supply(std::vector<StepResult> steps, double seconds) {
    if (action.further.empty()) {
      messages.supply(std::move(steps.front()), seconds);
    } else {
      messages.supply(std::move(steps), seconds);
    }
    changed_();
  }

  StreamMessages messages;
  const ValidatedStream action;
  std::stop_source stop;
  // Worker time of all finished steps.
  double worker_seconds = 0;
  std::shared_ptr<WorkTime> step_time;  // Null unless a step is being made.
  // Reserved for the step that is being sent.
  ByteReservations::Reservation memory = {};

 private:
  std::function<void()> changed_;
  std::weak_ptr<LocalServiceClient> service_client_;
};

void LocalServiceClient::enforce_limits(Clock::time_point now) {
  if (stream_ && stream_->step_time &&
      is_above_limit(stream_->worker_seconds + stream_->step_time->seconds(now))) {
    stream_->step_time.reset();
    client()->admission().observer().refused(client()->facts(), "request_seconds");
    stream_->fail(time_limit_error(service_.options().limits.request_time));
  }
  for (const JobPtr& job : jobs_) {
    if (job->is_late || !is_above_limit(job->time->seconds(now))) continue;
    job->is_late = true;
    job->stop.request_stop();
  }
}

std::optional<Error> LocalServiceClient::check_backlog() {
  const Backlog backlog = service_.workers().backlog(client()->quota_key());
  const double limit =
      std::chrono::duration<double>(service_.options().limits.waiting_time).count();
  if (limit <= 0 || backlog.seconds <= limit) return std::nullopt;
  client()->admission().observer().refused(client()->facts(), "waiting_seconds");
  return backlog_error(backlog, limit);
}

StepLimits LocalServiceClient::step_limits() const {
  return {.max_triangles = service_.options().limits.max_triangles,
          .bytes_per_second = bytes_per_second_};
}

// ---- streams

ProgressiveStreamPtr LocalServiceClient::steps(ValidatedStream action,
                                               std::function<void()> changed) {
  const auto refusal = check_backlog();
  stream_ = std::make_shared<Stream>(weak_from_this(), std::move(action), std::move(changed));
  if (refusal) {
    stream_->refuse(*refusal);
  } else {
    make_next_step();
  }
  return stream_;
}

void LocalServiceClient::make_next_step() {
  if (is_making_ || !stream_) return;
  const auto state = stream_->messages.take_request();
  if (!state) return;
  stream_->memory = {};
  // The guard keeps the executor running until the step is back. References are posted back, to be
  // released on the executor's thread.
  Work work = work_for(stream_->action, *state, stream_->stop.get_token());
  work.time = stream_->step_time = std::make_shared<WorkTime>();
  work.run = [self = shared_from_this(), stream = stream_, state = *state, limits = step_limits(),
              time = work.time, dataset = stream_->messages.dataset(),
              guard = asio::make_work_guard(service_.executor())]() mutable {
    const asio::any_io_executor executor = guard.get_executor();
    limits.is_contended = self->service_.workers().waiting() > 0;
    auto made = make_steps(stream->action, state, dataset, limits, stream->stop.get_token());
    multitetra::post(
        executor,
        [self = std::move(self), stream = std::move(stream),
         made = std::make_shared<Result<std::vector<StepResult>>>(std::move(made)),
         seconds = time->seconds()] { self->steps_made(stream, std::move(*made), seconds); });
  };
  service_.workers().post(in_queue(), std::move(work));
  is_making_ = true;
}

bool LocalServiceClient::is_above_limit(double seconds) const {
  const std::chrono::duration<double> limit = service_.options().limits.request_time;
  return limit.count() > 0 && seconds >= limit.count();
}

void LocalServiceClient::steps_made(const StreamPtr& stream, Result<std::vector<StepResult>> steps,
                                    double seconds) {
  is_making_ = false;
  stream->step_time.reset();
  client()->admission().observer().step_made(seconds);
  if (stream != stream_) {  // The stream was stopped; a newer one may be waiting.
    make_next_step();
    return;
  }
  stream->worker_seconds += seconds;
  if (!steps) {
    stream->fail(steps.error());
    return;
  }
  std::size_t bytes = 0;
  for (const StepResult& step : *steps) {
    bytes += static_cast<std::size_t>(size_of(step.encoded).bytes) + bytes_of(step.scalars);
  }
  auto reservation = client()->reserve(bytes);
  if (!reservation) {
    stream->fail(reservation.error());
    return;
  }
  stream->memory = *std::move(reservation);
  stream->supply(*std::move(steps), seconds);
}

// ---- surfaces and queries

template <typename T>
void LocalServiceClient::run(Work work, std::stop_token left,
                             std::function<Result<T>(const std::stop_token&)> make,
                             std::function<void(Result<T>, double seconds)> done) {
  const asio::any_io_executor& executor = service_.executor();
  if (const auto refusal = check_backlog()) {
    multitetra::post(executor,
                     [done = std::move(done), refusal] { done(tl::unexpected(*refusal), 0); });
    return;
  }
  const auto job = std::make_shared<Job>(std::move(left));
  jobs_.insert(job);
  work.time = job->time;
  // References are posted back, to be released on the executor's thread.
  work.run = [self = shared_from_this(), job, make = std::move(make), done = std::move(done),
              guard = asio::make_work_guard(executor)]() mutable {
    const asio::any_io_executor back = guard.get_executor();
    auto made = std::make_shared<Result<T>>(make(job->stop.get_token()));
    make = nullptr;
    multitetra::post(back, [self = std::move(self), job = std::move(job), made = std::move(made),
                            done = std::move(done)] {
      self->jobs_.erase(job);
      if (!*made && job->is_late) {
        self->client()->admission().observer().refused(self->client()->facts(), "request_seconds");
        *made = tl::unexpected(time_limit_error(self->service_.options().limits.request_time));
      }
      done(std::move(*made), job->time->seconds());
    });
  };
  service_.workers().post(in_queue(), std::move(work));
}

void LocalServiceClient::answer(ValidatedQuery action, std::stop_token stop, UseReply use,
                                QueryDone done) {
  Work work = work_for(action);
  run<DatasetQueryReply>(
      std::move(work), std::move(stop),
      [action = std::move(action), use = std::move(use)](const std::stop_token& of_job) {
        return make_answer(action, of_job, use);
      },
      [done = std::move(done)](Result<DatasetQueryReply> reply, double) {
        done(std::move(reply));
      });
}

void LocalServiceClient::make_surface(ValidatedStream action, std::uint64_t max_triangles,
                                      std::string what, std::stop_token stop, UseSurface use,
                                      std::function<void(Result<void>)> done) {
  const StreamState state{.request = action.open.request, .steps = StepPolicy::kFinalOnly};
  Work work = work_for(action, state, stop);
  work.kind += ' ' + what;
  run<void>(
      std::move(work), std::move(stop),
      [action = std::move(action), max_triangles, limits = step_limits(), what = std::move(what),
       use = std::move(use)](const std::stop_token& of_job) {
        return make_mesh(action, max_triangles, limits, of_job, what, use);
      },
      [this, done = std::move(done)](Result<void> made, double seconds) {
        client()->admission().observer().step_made(seconds);
        done(std::move(made));
      });
}

}  // namespace

// ---- the service

LocalService::LocalService(asio::any_io_executor executor, CataloguePtr catalogue,
                           LocalServiceOptions options)
    : executor_(std::move(executor)),
      catalogue_(std::move(catalogue)),
      options_(std::move(options)),
      workers_(options_.workers) {}
LocalService::~LocalService() = default;

ServiceState LocalService::state() const {
  ServiceState state = options_.cache ? state_of(options_.cache->tiles()) : ServiceState{};
  state.waiting_jobs = workers_.waiting();
  state.datasets = catalogue_->size();
  if (options_.blocks) state.blocks = options_.blocks();
  return state;
}

ServiceClientPtr LocalService::open(ConnectionContextPtr client) {
  return std::make_shared<LocalServiceClient>(*this, std::move(client));
}

std::optional<TileCache::Found> LocalService::find_tile(const ContentDigest& digest,
                                                        const TileCache::MaySee& may_see) {
  if (!options_.cache) return std::nullopt;
  return options_.cache->tiles().find_by_digest(digest, may_see);
}

}  // namespace multitetra
