#include "client/load/load_session.hpp"

#include <algorithm>
#include <utility>

#include "common/net/coroutines.hpp"

namespace multitetra {

namespace {

double seconds_since(LoadClock::time_point begin) {
  return std::chrono::duration<double>(LoadClock::now() - begin).count();
}

// Closes a channel after a time limit, unless destroyed before.
class ClosesAfter {
 public:
  ClosesAfter(asio::io_context& io, std::shared_ptr<MessageChannel> channel,
              std::chrono::milliseconds limit)
      : timer_(io, limit) {
    when_expired(timer_, [channel = std::move(channel)] { channel->close(); });
  }

 private:
  asio::steady_timer timer_;
};

// Waits for the server's delay plus up to 25 %, so that clients rejected together return apart.
std::chrono::milliseconds wait_after(const Error& refusal, std::mt19937_64& random) {
  const double later = 1 + 0.25 * static_cast<double>(random() >> 11) * 0x1p-53;
  return std::chrono::milliseconds(static_cast<std::int64_t>(1000 * refusal.retry_after * later));
}

enum class Ending { kNone, kComplete, kReplaced, kFailed, kUnfinished };

}  // namespace

struct LoadSession::RunningStream {
  RunningStream(ScriptedRequest scripted_in, const DatasetInfo& info_in, StreamChecks checks_in)
      : scripted(std::move(scripted_in)), info(info_in), checks(std::move(checks_in)) {}

  ScriptedRequest scripted;
  const DatasetInfo& info;
  StreamChecks checks;
  LoadClock::time_point requested = LoadClock::now();
  // When the last message from the server arrived.
  LoadClock::time_point last_message_at = LoadClock::now();
  // Whether a Ping was sent since then.
  bool has_pending_ping = false;
  // When the request is repeated.
  std::optional<LoadClock::time_point> resume_at;
  std::set<ContentDigest> tiles;  // Received over all connections.
  std::optional<StepBegin> begun;
  double last_tile = 0;
  bool has_step = false;
  Ending ending = Ending::kNone;
};

LoadSession::LoadSession(asio::io_context& io, const UserOptions& options, std::uint64_t seed,
                         std::chrono::milliseconds delay, std::string from,
                         LoadStatistics& statistics, Agreement& agreement)
    : options_(options),
      statistics_(statistics),
      agreement_(agreement),
      io_(io),
      news_(io.get_executor()),
      random_(seed),
      seed_(seed),
      delay_(delay),
      from_(std::move(from)) {}
LoadSession::~LoadSession() = default;

asio::awaitable<void> LoadSession::run() {
  co_await wait_until(options_.start + delay_);
  while (LoadClock::now() < options_.stop) {
    if (!channel_) {
      co_await reconnect();
      if (!channel_) break;
    }
    if (options_.is_idle) {
      co_await wait_until(options_.stop);
      continue;
    }
    if (!script_) {
      script_.emplace(options_.script, datasets_, seed_, options_.script_options);
    }
    ScriptedRequest scripted = script_->next();
    const auto pause = scripted.pause;
    co_await play(std::move(scripted));
    co_await wait_until(std::min(LoadClock::now() + pause, options_.stop));
  }
  if (datasets_.empty()) ++statistics_.clients_without_connection;
  if (channel_) {
    const ChannelPtr channel = channel_;
    const ClosesAfter limit(io_, channel, std::chrono::milliseconds(500));
    leave();
    co_await channel->close_gracefully();
  }
}

// ---- connections

// Retries until the server sends Welcome or the time is over, with delays that grow to two seconds.
asio::awaitable<void> LoadSession::reconnect() {
  const auto until = stream_ ? options_.give_up : options_.stop;
  while (LoadClock::now() < until) {
    const bool is_welcomed = co_await connect();
    if (is_welcomed) co_return;
    const int doublings = std::min(failures_in_a_row_++, 5);
    const auto wait = std::max(std::chrono::milliseconds(60 << doublings), least_wait_);
    const auto jitter = std::chrono::milliseconds(random_() % 60);
    co_await wait_until(std::min(LoadClock::now() + wait + jitter, until));
  }
}

asio::awaitable<bool> LoadSession::connect() {
  const auto began = LoadClock::now();
  const auto channel = std::make_shared<MessageChannel>(
      io_.get_executor(), options_.server,
      ChannelOptions{
          .tls = options_.tls, .transport = {.read_buffer_bytes = 16 * 1024}, .from = from_});
  auto datasets = co_await enter(channel);
  if (!datasets) {
    channel->close();
    ++statistics_.failed_attempts;
    statistics_.add_error(datasets.error());
    least_wait_ = wait_after(datasets.error(), random_);
    co_return false;
  }
  statistics_.connect.add(seconds_since(began));
  ++statistics_.connections;
  failures_in_a_row_ = 0;
  if (!options_.dataset.empty()) {
    std::erase_if(*datasets,
                  [this](const DatasetInfo& info) { return info.name != options_.dataset; });
  }
  // A resumed stream refers to the original list.
  if (datasets_.empty()) datasets_ = *std::move(datasets);
  if (datasets_.empty()) {
    statistics_.add_error({ErrorCode::kUnknownDataset, "The server has no such dataset."});
    channel->close();
    co_return false;
  }
  channel_ = channel;
  spawn(io_.get_executor(), [this, channel] { return listen(channel); });
  co_return true;
}

asio::awaitable<Result<std::vector<DatasetInfo>>> LoadSession::enter(ChannelPtr channel) {
  const ClosesAfter limit(io_, channel, options_.timeout);
  const auto opened = co_await channel->open();
  if (!opened) co_return tl::unexpected(opened.error());
  Hello hello;
  hello.token = options_.token;
  hello.agent = "multitetra-load/" MULTITETRA_VERSION;
  const auto welcome = co_await request(channel, serialize(hello));
  if (!welcome) co_return tl::unexpected(welcome.error());
  ListDatasets all;  // Named, as GCC 12 destroys aggregates in a co_await expression twice.
  all.request_id = 1;
  auto list = co_await request(channel, serialize(all));
  if (!list) co_return tl::unexpected(list.error());
  if (auto* datasets = std::get_if<DatasetList>(&*list)) co_return std::move(datasets->datasets);
  co_return fail(ErrorCode::kUnexpectedMessage, "The server did not send a list of datasets.");
}

// Sends a request and returns the next message; an ErrorReply is returned as its error.
asio::awaitable<Result<ServerMessage>> LoadSession::request(ChannelPtr channel,
                                                            std::string content) {
  const auto sent = co_await channel->send(std::move(content));
  if (!sent) co_return tl::unexpected(sent.error());
  const auto received = co_await channel->receive();
  if (!received) co_return tl::unexpected(received.error());
  auto message = parse_server_message(*received);
  if (!message) co_return tl::unexpected(message.error().error);
  if (const auto* refusal = std::get_if<ErrorReply>(&*message)) {
    co_return tl::unexpected(refusal->error);
  }
  co_return *std::move(message);
}

// Processes all messages of a connection until it ends.
asio::awaitable<void> LoadSession::listen(ChannelPtr channel) {
  for (;;) {
    const auto content = co_await channel->receive();
    if (channel != channel_) co_return;
    if (!content) {
      handle_lost_connection(content.error());
      co_return;
    }
    const auto message = parse_server_message(*content);
    if (message) {
      take(*message);
    } else {
      fail_check(message.error().error.text);
    }
  }
}

void LoadSession::handle_lost_connection(const Error& error) {
  ++statistics_.lost_connections;
  statistics_.add_error(error);
  leave();
  notify();
}

void LoadSession::leave() {
  if (!channel_) return;
  statistics_.wire_bytes += channel_->bytes_received();
  channel_.reset();
}

// ---- streams

asio::awaitable<void> LoadSession::play(ScriptedRequest scripted) {
  const auto info = std::find_if(
      datasets_.begin(), datasets_.end(),
      [&scripted](const DatasetInfo& dataset) { return dataset.name == scripted.open.dataset; });
  const bool is_thorough = options_.streams_per_thorough > 0 &&
                           (seed_ + streams_++) % options_.streams_per_thorough == 0;
  const OpenStream open = scripted.open;
  stream_ = std::make_unique<RunningStream>(
      std::move(scripted), *info,
      is_thorough ? StreamChecks::thorough(*info, open, {})
                  : StreamChecks::cheap(*info, open, options_.tiles_per_decoded));
  ++statistics_.streams;
  if (is_thorough) ++statistics_.thorough_streams;
  co_await send_open_stream();
  while (stream_->ending == Ending::kNone) co_await act_or_wait();
  count_ended_stream();
  stream_.reset();
}

// Does what is due for the stream, or else waits until something is or a message arrives.
asio::awaitable<void> LoadSession::act_or_wait() {
  RunningStream& stream = *stream_;
  const auto now = LoadClock::now();
  const auto silent_at = stream.last_message_at + options_.timeout;
  const auto ping_at = stream.has_pending_ping ? silent_at : silent_at - options_.timeout / 2;
  auto until = std::min(ping_at, options_.give_up);
  if (stream.resume_at) until = std::min(until, *stream.resume_at);
  if (stream.scripted.replaced_after) {
    until = std::min({until, stream.requested + *stream.scripted.replaced_after, options_.stop});
  }
  if (now >= options_.give_up) {
    stream.ending = Ending::kUnfinished;
  } else if (stream.scripted.replaced_after && now >= until && now < ping_at) {
    stream.ending = Ending::kReplaced;
  } else if (now >= silent_at && channel_) {
    channel_->close();
    handle_lost_connection(
        {ErrorCode::kUnavailable, "The server has not sent anything for too long."});
  } else if (now >= ping_at && channel_) {
    // A busy server may delay requests, but answers a Ping; a lost one does not.
    stream.has_pending_ping = true;
    const ChannelPtr channel = channel_;
    co_await channel->send(serialize(Ping{}));
  } else if (!channel_) {
    co_await reconnect();
    if (channel_) co_await send_open_stream();
  } else if (stream.resume_at && now >= *stream.resume_at) {
    co_await send_open_stream();
  } else {
    co_await wait_until(until);
  }
}

void LoadSession::count_ended_stream() {
  const RunningStream& stream = *stream_;
  statistics_.tiles_decoded += stream.checks.tiles_decoded();
  switch (stream.ending) {
    case Ending::kComplete:
      ++statistics_.complete;
      statistics_.whole.add(seconds_since(stream.requested));
      if (!stream.tiles.empty()) statistics_.last_tile.add(stream.last_tile);
      break;
    case Ending::kReplaced:
      ++statistics_.replaced;
      break;
    case Ending::kFailed:
      ++statistics_.failed;
      break;
    case Ending::kNone:
    case Ending::kUnfinished:
      ++statistics_.unfinished;
      break;
  }
}

// Requests the stream, or its remainder after a lost connection.
asio::awaitable<void> LoadSession::send_open_stream() {
  const ChannelPtr channel = channel_;
  if (!channel) co_return;
  RunningStream& stream = *stream_;
  OpenStream open = stream.scripted.open;
  open.request_id = ++last_request_id_;
  open.cached_tile_digests = stream.checks.held_digests();
  statistics_.tiles_decoded += stream.checks.tiles_decoded();
  stream.checks = stream.checks.resumed(stream.info, open);
  stream.begun.reset();
  stream.resume_at.reset();
  stream.last_message_at = LoadClock::now();
  stream.has_pending_ping = false;
  const ClosesAfter limit(io_, channel, options_.timeout);
  co_await channel->send(serialize(open));  // listen() reports its errors.
}

void LoadSession::take(const ServerMessage& message) {
  if (!stream_ || stream_->ending != Ending::kNone) return;
  stream_->last_message_at = LoadClock::now();
  stream_->has_pending_ping = false;
  if (std::holds_alternative<Pong>(message)) return;
  if (const auto* tile = std::get_if<Tile>(&message)) note_tile(*tile);
  const auto progress = stream_->checks.receive(message);
  if (!progress) {
    fail_check(progress.error().text);
  } else {
    if (const auto* begin = std::get_if<StepBegin>(&message)) {
      if (begin->request_id == last_request_id_) stream_->begun = *begin;
    }
    take_progress(*progress);
  }
}

// Records times and counts, and checks that no tile is sent twice, even across reconnections.
void LoadSession::note_tile(const Tile& tile) {
  if (tile.request_id != last_request_id_ || !stream_->begun ||
      tile.index >= stream_->begun->tiles.size()) {
    return;
  }
  const double seconds = seconds_since(stream_->requested);
  if (stream_->tiles.empty()) statistics_.first_tile.add(seconds);
  stream_->last_tile = seconds;
  ++statistics_.tiles;
  statistics_.payload_bytes += tile.payload->size();
  statistics_.seconds = std::max(statistics_.seconds, seconds_since(options_.start));
  const bool is_new = stream_->tiles.insert(stream_->begun->tiles[tile.index].digest).second;
  if (!is_new) ++statistics_.tiles_sent_twice;
}

void LoadSession::take_progress(const StreamProgress& progress) {
  RunningStream& stream = *stream_;
  if (const auto* step = std::get_if<WholeStep>(&progress)) {
    ++statistics_.steps;
    if (!stream.has_step) statistics_.first_step.add(seconds_since(stream.requested));
    stream.has_step = true;
    const auto verdict =
        agreement_.compare(stream.scripted.open.dataset, step->begin, step->digest);
    if (verdict == Agreement::Verdict::kSame) ++statistics_.steps_compared;
    if (verdict == Agreement::Verdict::kDifferent) {
      fail_check("Step " + std::to_string(step->begin.step) +
                 ": another client received a different mesh for the same parameters.");
    }
  } else if (const auto* end = std::get_if<StreamEnd>(&progress)) {
    if (end->outcome == StreamOutcome::kComplete) {
      stream.ending = Ending::kComplete;
      notify();
    } else {
      fail_check("The server ended the stream before its final step.");
    }
  } else if (const auto* refusal = std::get_if<Refusal>(&progress)) {
    take_refusal(refusal->error);
  }
}

void LoadSession::take_refusal(const Error& error) {
  RunningStream& stream = *stream_;
  if (error.retry_after > 0) {
    ++statistics_.retried_after_delay;
    stream.resume_at = LoadClock::now() + wait_after(error, random_);
    stream.last_message_at = *stream.resume_at;
    notify();
    return;
  }
  // The server, or a replacement, may become available again.
  if (error.code == ErrorCode::kUnavailable) {
    if (channel_) channel_->close();
    handle_lost_connection(error);
    return;
  }
  statistics_.add_error(error);
  stream.ending = Ending::kFailed;
  notify();
}

// Ends the connection, as its data can no longer be trusted.
void LoadSession::fail_check(const std::string& text) {
  statistics_.add_failed_check(
      text + (stream_ ? " Dataset \"" + stream_->scripted.open.dataset + "\", isovalue " +
                            std::to_string(stream_->scripted.open.request.isovalue) + ", error " +
                            std::to_string(stream_->scripted.open.request.error) + "."
                      : ""));
  if (stream_) stream_->ending = Ending::kFailed;
  if (channel_) channel_->close();
  leave();
  notify();
}

// ---- waiting

void LoadSession::notify() {
  has_news_ = true;
  news_.notify_all();
}

// Waits until `time` or until notify() is called.
asio::awaitable<void> LoadSession::wait_until(LoadClock::time_point time) {
  if (!std::exchange(has_news_, false)) {
    co_await news_.wait_until(time);
    has_news_ = false;
  }
}

}  // namespace multitetra
