#include "server/transport/worker_backend.hpp"

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

#include "common/base/in_parallel.hpp"
#include "common/base/number_text.hpp"
#include "common/net/coroutines.hpp"
#include "server/core/planning/budget.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"
#include "server/dataset/byte_source.hpp"
#include "server/operations/log.hpp"
#include "server/store/store_error.hpp"
#include "server/stream/stream_messages.hpp"
#include "server/transport/connection.hpp"

namespace multitetra {

// Workers hold it as well; they touch only source and stop.
class WorkerBackend::Stream : public BackendStream {
 public:
  Stream(std::weak_ptr<WorkerBackend> backend, StartStream action, std::function<void()> changed)
      : scalar_range(range_of(action)),
        messages(action.open, action.source->info(), scalar_range),
        source(std::move(action.source)),
        scalars(std::move(action.scalars)),
        priority(action.open.priority),
        changed_(std::move(changed)),
        backend_(std::move(backend)) {}

  std::optional<ServerMessage> take() override {
    if (!messages.has_message()) return std::nullopt;
    ServerMessage message = messages.take();
    const auto backend = backend_.lock();
    if (backend && backend->stream_.get() == this) backend->make_next_step();
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
  // A worker may hold it still; what it took of others is given back now.
  void drop() override {
    stop.request_stop();
    queue_reservation = {};
    const auto backend = backend_.lock();
    if (backend && backend->stream_.get() == this) backend->stream_.reset();
  }
  // Its next step; runs on a worker.
  [[nodiscard]] Result<MadeStep> make(const StreamState& state, const StepLimits& limits) const;
  // Before anybody was told of it.
  void refuse(Error error) { messages.fail(std::move(error)); }
  void supply(MadeStep step, double seconds) {
    messages.supply(std::move(step), seconds);
    changed_();
  }

  std::optional<ScalarRange> scalar_range;
  StreamMessages messages;
  std::shared_ptr<const StepSource> source;
  std::shared_ptr<const StepSource> scalars;  // Null without.
  Priority priority;
  std::stop_source stop;
  double worker_seconds = 0;                             // Of the steps that were made.
  Deadline worker;                                       // While a step is with a worker.
  ByteReservations::Reservation queue_reservation = {};  // Of the step that is being sent.

 private:
  static std::optional<ScalarRange> range_of(const StartStream& action) {
    if (!action.scalars) return std::nullopt;
    return range_for(*action.open.scalars, action.scalars->info());
  }

  std::function<void()> changed_;
  std::weak_ptr<WorkerBackend> backend_;
};

struct WorkerBackend::QuestionJob {
  QuestionJob(AnswerQuestion action, std::stop_token left,
              std::function<void(Result<QuestionReply>)> done_in)
      : asked(std::move(action.question)),
        source(std::move(action.source)),
        done(std::move(done_in)),
        leave(std::move(left), [this] { stop.request_stop(); }) {}

  Question asked;
  std::shared_ptr<const StepSource> source;
  std::function<void(Result<QuestionReply>)> done;
  std::stop_source stop;
  Deadline worker;
  bool is_late = false;
  std::stop_callback<std::function<void()>> leave;
};

namespace {

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

constexpr double kStoreRetrySeconds = 5;

// Runs on a worker. The client learns that something went wrong here; the log says what.
template <typename Make>
auto guarded(const StepSource& source, const char* what, const std::stop_token& stop,
             const Make& make) -> decltype(make()) {
  try {
    if (stop.stop_requested()) throw Cancelled{};
    return make();
  } catch (const Cancelled&) {
    return fail(ErrorCode::kCancelled, std::string("The ") + what + " was cancelled.");
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kLimitExceeded,
                std::string("The server has not enough memory for this ") + what +
                    "; ask for a larger error.");
  } catch (const DatasetFileError& damage) {
    log_line(LogLevel::kError, damage.what(), {{"dataset", source.info().name}});
    return fail(ErrorCode::kDamagedData, std::string("The dataset's file is damaged where this ") +
                                             what + " needs it; the server's log says where.");
  } catch (const StoreError& trouble) {
    log_line(LogLevel::kError, trouble.what(), {{"dataset", source.info().name}});
    return tl::unexpected(
        Error{.code = ErrorCode::kUnavailable,
              .text = std::string("The store of this dataset does not answer, or not "
                                  "as it should, and this ") +
                      what + " needs it; the server's log says more. Try again.",
              .retry_after = kStoreRetrySeconds});
  } catch (const std::exception& trouble) {
    log_line(LogLevel::kError, std::string("making the ") + what + " failed: " + trouble.what(),
             {{"dataset", source.info().name}});
    return fail(ErrorCode::kInternal,
                std::string("The server failed to make this ") + what + "; its log says why.");
  }
}

// The scalars of a step that was made.
Result<MadeStep> with_scalars(MadeStep made, const DatasetInfo& surface, const StepSource& field,
                              const ScalarRange& range, const std::stop_token& stop) {
  return guarded(field, "step", stop, [&]() -> Result<MadeStep> {
    const PreparedVolume* volume = field.volume();
    if (volume == nullptr) {
      return fail(ErrorCode::kInternal, "This server has no samples of the colouring dataset.");
    }
    auto scalars = step_scalars(made.encoded, made.step.request, surface, *volume, range, stop);
    if (!scalars) return tl::unexpected(scalars.error());
    made.scalars = *std::move(scalars);
    return std::move(made);
  });
}

// What was made before is quickly found, and so is a first preview; what follows may take as long
// as the whole.
struct StepWork {
  std::string kind;
  bool is_long = false;
};
StepWork work_for(const StepSource& source, const StreamState& state) {
  const std::string& dataset = source.info().name;
  const IsosurfaceRequest& request = state.request;
  // What a budget gives is only known when it was made.
  if (!has_budget(request) && source.remembers(final_step(request))) {
    return {.kind = dataset + " remembered", .is_long = false};
  }
  if (request.cell) {
    return {.kind = dataset + " cell", .is_long = request.cell->finest_spacing < kSpectrumSpacing};
  }
  if (state.steps != StepPolicy::kFinalOnly && state.shown.empty()) {
    return {.kind = dataset + " first preview", .is_long = false};
  }
  return {.kind = dataset + (request.simplify ? " simplified step" : " step"), .is_long = true};
}

// What takes longer with every place that is to be looked at.
bool has_large_map(const IsosurfaceRequest* request) {
  constexpr std::size_t kMany = 64;
  return request && (request->thresholds.regions.size() > kMany || request->thresholds.grid);
}

// What takes about as long as others of its kind.
StepWork work_for(const StepSource& source, const Question& question) {
  return {.kind = source.info().name + (is_long(question) ? " long " : " short ") +
                  kind_of(question) + (has_large_map(request_of(question)) ? " of a map" : ""),
          .is_long = is_long(question)};
}

Error come_again(const Backlog& backlog, double limit) {
  const double share_of_time = backlog.seconds_until_done / backlog.seconds;
  const double seconds = std::ceil(std::max(1.0, (backlog.seconds - limit) * share_of_time));
  return {.code = ErrorCode::kUnavailable,
          .text = "What you asked for already takes this server about " +
                  shortest_text(std::ceil(backlog.seconds)) + " s; ask again in " +
                  shortest_text(seconds) + " s.",
          .retry_after = seconds};
}

Error too_long(std::chrono::milliseconds limit) {
  return {ErrorCode::kLimitExceeded,
          "The answer takes this server longer than the " +
              shortest_text(static_cast<double>(limit.count()) / 1000) +
              " s that it spends on one request; ask for a larger error."};
}

}  // namespace

Result<MadeStep> WorkerBackend::Stream::make(const StreamState& state,
                                             const StepLimits& limits) const {
  const std::stop_token of_stream = stop.get_token();
  auto made = guarded(*source, "step", of_stream, [&] {
    return multitetra::make_next_step(*source, state, of_stream, limits);
  });
  if (!made || made->is_over || !scalars) return made;
  return with_scalars(*std::move(made), source->info(), *scalars, *scalar_range, of_stream);
}

WorkerBackend::WorkerBackend(asio::any_io_executor executor, Workers& workers,
                             ClientContextPtr client, const SessionLimits& limits)
    : executor_(executor),
      workers_(workers),
      queue_number_(workers.new_client()),
      client_(std::move(client)),
      limits_(limits) {}
WorkerBackend::~WorkerBackend() = default;

void WorkerBackend::keep_time(Clock::time_point now) {
  if (stream_ && stream_->worker.is_past(now)) {
    stream_->worker.clear();
    client_->admission().observer().refused(client_->facts(), "request_seconds");
    stream_->fail(too_long(limits_.request_time));
  }
  for (const QuestionPtr& job : questions_) {
    if (!job->worker.is_past(now)) continue;
    job->worker.clear();
    job->is_late = true;
    job->stop.request_stop();
  }
}

FairQueue::Client WorkerBackend::queue_client() const { return {client_->share(), queue_number_}; }

std::optional<Error> WorkerBackend::check_backlog() {
  const Backlog backlog = workers_.backlog(client_->share());
  const double limit = std::chrono::duration<double>(limits_.waiting_time).count();
  if (limit <= 0 || backlog.seconds <= limit) return std::nullopt;
  client_->admission().observer().refused(client_->facts(), "waiting_seconds");
  return come_again(backlog, limit);
}

// ---- streams

BackendStreamPtr WorkerBackend::start(StartStream action, std::function<void()> changed) {
  const auto refusal = check_backlog();
  stream_ = std::make_shared<Stream>(weak_from_this(), std::move(action), std::move(changed));
  if (refusal) {
    stream_->refuse(*refusal);
  } else {
    make_next_step();
  }
  return stream_;
}

void WorkerBackend::make_next_step() {
  if (is_making_ || !stream_) return;
  const auto state = stream_->messages.wanted();
  if (!state) return;
  stream_->queue_reservation = {};
  // The guard keeps the executor running until the step has come back. What belongs to the
  // executor's thread is given back to it, and let go there.
  auto make = [self = shared_from_this(), stream = stream_, state = *state,
               limits = StepLimits{.max_triangles = limits_.max_triangles,
                                   .bytes_per_second = bytes_per_second_},
               guard = asio::make_work_guard(executor_)]() mutable {
    const asio::any_io_executor executor = self->executor_;
    post(executor, [self, stream] { self->step_begins(stream); });
    const Clock::time_point start = Clock::now();
    limits.others_wait = self->workers_.waiting() > 0;
    auto made = stream->make(state, limits);
    post(executor,
         [self = std::move(self), stream = std::move(stream),
          made = std::make_shared<Result<MadeStep>>(std::move(made)),
          seconds = seconds_since(start)] { self->step_made(stream, std::move(*made), seconds); });
  };
  StepWork work = work_for(*stream_->source, *state);
  workers_.post(queue_client(), {.run = std::move(make),
                                 .kind = std::move(work.kind),
                                 .is_long = work.is_long,
                                 .is_background = stream_->priority == Priority::kBackground});
  is_making_ = true;
}

void WorkerBackend::step_begins(const StreamPtr& stream) {
  if (limits_.request_time.count() <= 0 || stream != stream_) return;
  const std::chrono::duration<double> left =
      limits_.request_time - std::chrono::duration<double>(stream->worker_seconds);
  stream->worker.set(std::chrono::duration_cast<Clock::duration>(left));
}

void WorkerBackend::step_made(const StreamPtr& stream, Result<MadeStep> step, double seconds) {
  is_making_ = false;
  stream->worker.clear();
  client_->admission().observer().step_made(seconds);
  if (stream != stream_) {  // It was stopped; the stream after it, if any, has waited.
    make_next_step();
    return;
  }
  stream->worker_seconds += seconds;
  if (!step) {
    stream->fail(step.error());
    return;
  }
  const std::size_t bytes =
      static_cast<std::size_t>(size_of(step->encoded).bytes) + bytes_of(step->scalars);
  auto reservation = client_->take_room(bytes);
  if (!reservation) {
    stream->fail(reservation.error());
    return;
  }
  stream->queue_reservation = *std::move(reservation);
  stream->supply(*std::move(step), seconds);
}

// ---- questions

void WorkerBackend::answer(AnswerQuestion action, std::stop_token stop,
                           std::function<void(Result<QuestionReply>)> done) {
  if (const auto refusal = check_backlog()) {
    post(executor_, [done = std::move(done), refusal] { done(tl::unexpected(*refusal)); });
    return;
  }
  StepWork work = work_for(*action.source, action.question);
  const auto job =
      std::make_shared<QuestionJob>(std::move(action), std::move(stop), std::move(done));
  questions_.insert(job);
  // What belongs to the executor's thread is given back to it, and let go there.
  auto make = [self = shared_from_this(), job, guard = asio::make_work_guard(executor_)]() mutable {
    const asio::any_io_executor executor = self->executor_;
    post(executor, [limit = self->limits_.request_time, job] {
      if (limit.count() > 0) job->worker.set(limit);
    });
    const std::stop_token of_job = job->stop.get_token();
    auto made = guarded(*job->source, kind_of(job->asked), of_job,
                        [&] { return answered(*job->source, job->asked, of_job); });
    post(executor, [self = std::move(self), job = std::move(job), made = std::move(made)] {
      self->answer_made(job, made);
    });
  };
  workers_.post(queue_client(),
                {.run = std::move(make),
                 .kind = std::move(work.kind),
                 .is_long = work.is_long,
                 .is_background = priority_of(job->asked) == Priority::kBackground});
}

void WorkerBackend::answer_made(const QuestionPtr& job, Result<QuestionReply> made) {
  questions_.erase(job);
  if (!made && job->is_late) {
    client_->admission().observer().refused(client_->facts(), "request_seconds");
    made = tl::unexpected(too_long(limits_.request_time));
  }
  job->done(std::move(made));
}

}  // namespace multitetra
