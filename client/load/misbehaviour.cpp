#include "client/load/misbehaviour.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "common/base/enum_names.hpp"
#include "common/wire/messages.hpp"

namespace multitetra {

using Clock = std::chrono::steady_clock;

namespace {

constexpr EnumNames<Misbehaviour, 6> kNames = {
    {"stalled", "slow", "leaving", "garbage", "greedy", "hoarding"}};

// The most regions and the largest grid that a request may have.
LocalThresholds largest_map() {
  LocalThresholds map;
  map.regions.resize(kMaxThresholdRegions, {.shape = BallShape{.radius = 1}, .threshold = 0.5});
  auto grid = std::make_shared<ThresholdGrid>();
  const auto side = static_cast<std::int32_t>(std::cbrt(kMaxGridThresholds));
  grid->dims = {side, side, side};
  grid->thresholds.assign(static_cast<std::size_t>(side) * side * side, 0.5F);
  map.grid = std::move(grid);
  return map;
}

std::string framed(const std::string& content) {
  return frame_header(static_cast<std::uint32_t>(content.size())) + content;
}

std::string random_bytes(std::mt19937_64& random, std::size_t count) {
  std::string bytes(count, '\0');
  for (char& byte : bytes) byte = static_cast<char>(random());
  return bytes;
}

// One client, which reconnects after every connection. Requests the first dataset if none is named.
class MisbehavingClient {
 public:
  MisbehavingClient(Misbehaviour kind, const UserOptions& options, std::uint64_t seed,
                    std::string from, MisbehaviourCounts& counts, asio::any_io_executor executor)
      : kind_(kind),
        options_(options),
        random_(seed),
        from_(std::move(from)),
        counts_(counts),
        executor_(executor),
        timer_(executor) {}

  asio::awaitable<void> run(std::chrono::milliseconds delay) {
    co_await sleep_until(options_.start + delay);
    while (Clock::now() < options_.stop) {
      const auto channel = std::make_shared<MessageChannel>(
          executor_, address(),
          ChannelOptions{
              .tls = options_.tls, .transport = {.read_buffer_bytes = 4096}, .from = from_});
      // Ends waits for the server when the run ends.
      asio::steady_timer end(executor_, options_.stop);
      end.async_wait([channel](const error_code& cancelled) {
        if (!cancelled) channel->close();
      });
      const auto opened = co_await channel->open();
      if (opened) {
        ++counts_.connections;
        co_await misbehave_on(channel);
        channel->close();
        co_await sleep(std::chrono::milliseconds(random_() % 100));
      } else {
        ++counts_.failed_attempts;
        co_await sleep(std::chrono::milliseconds(100 + random_() % 400));
      }
    }
  }

 private:
  using ChannelPtr = std::shared_ptr<MessageChannel>;

  // kSlow and every other kGarbage connection skip the WebSocket handshake.
  Endpoint address() {
    const bool is_raw =
        kind_ == Misbehaviour::kSlow || (kind_ == Misbehaviour::kGarbage && random_() % 2 == 0);
    Endpoint server = options_.server;
    if (is_raw && server.is_web_socket()) {
      server.transport = server.is_secure() ? Transport::kTls : Transport::kTcp;
    }
    return server;
  }

  asio::awaitable<void> misbehave_on(ChannelPtr channel) {
    switch (kind_) {
      case Misbehaviour::kStalled:
        co_await stall(channel);
        break;
      case Misbehaviour::kSlow:
        co_await send_slowly(channel);
        break;
      case Misbehaviour::kLeaving:
        co_await leave(channel);
        break;
      case Misbehaviour::kGarbage:
        co_await send_garbage(channel);
        break;
      case Misbehaviour::kGreedy:
        co_await overload(channel);
        break;
      case Misbehaviour::kHoarding:
        co_await hoard(channel);
        break;
    }
  }

  // Exchanges Hello and lists the datasets; returns a dataset's name, or empty if refused.
  asio::awaitable<std::string> enter(ChannelPtr channel) {
    Hello hello;
    hello.token = options_.token;
    const bool greeted = co_await sent(channel, hello);
    if (!greeted) co_return "";
    const auto welcome = co_await channel->receive();
    if (!welcome) co_return "";
    std::vector<DatasetInfo> datasets;
    while (datasets.empty() && Clock::now() < options_.stop) {
      ListDatasets query;
      query.request_id = 1;
      const bool is_sent = co_await sent(channel, query);
      if (!is_sent) co_return "";
      const auto content = co_await channel->receive();
      if (!content) co_return "";
      auto message = parse_server_message(*content);
      auto* list = message ? std::get_if<DatasetList>(&*message) : nullptr;
      if (list != nullptr) datasets = std::move(list->datasets);
      // Retries after a rate limit.
      if (list == nullptr) co_await sleep(std::chrono::milliseconds(200 + random_() % 200));
    }
    for (const DatasetInfo& info : datasets) {
      if (!options_.dataset.empty() && info.name != options_.dataset) continue;
      if (!info.suggested_isovalues.empty()) isovalue_ = info.suggested_isovalues.front();
      range_ = info.max - info.min;
      co_return info.name;
    }
    co_return "";
  }

  OpenStream request(const std::string& dataset, std::uint64_t id) {
    return {.request_id = id,
            .dataset = dataset,
            .request = {.isovalue = isovalue_, .error = 0.5},
            .cached_tile_digests = {}};
  }

  // Never reads, so that the server's data fills all buffers.
  asio::awaitable<void> stall(ChannelPtr channel) {
    const std::string dataset = co_await enter(channel);
    if (dataset.empty()) {
      ++counts_.ended_by_server;
      co_return;
    }
    for (std::uint64_t id = 1; Clock::now() < options_.stop; ++id) {
      const bool is_sent = co_await sent(channel, request(dataset, id));
      if (!is_sent) {
        ++counts_.ended_by_server;
        co_return;
      }
      co_await sleep(std::chrono::seconds(5));
    }
  }

  asio::awaitable<void> send_slowly(ChannelPtr channel) {
    const std::string greeting = options_.server.is_web_socket()
                                     ? "GET " + options_.server.path +
                                           " HTTP/1.1\r\nHost: " + options_.server.host +
                                           "\r\nX-Patience: " + std::string(2000, 'a')
                                     : framed(serialize(Hello{.token = std::string(4000, 'a')}));
    for (const char byte : greeting) {
      const bool is_sent = co_await sent_raw(channel, std::string(1, byte));
      if (!is_sent || Clock::now() >= options_.stop) {
        if (!is_sent) ++counts_.ended_by_server;
        co_return;
      }
      co_await sleep(std::chrono::seconds(1));
    }
  }

  asio::awaitable<void> leave(ChannelPtr channel) {
    const auto words = random_() % 4;
    if (words == 0) co_return;
    if (words == 1) {
      co_await sent_raw(channel, random_bytes(random_, 3));
      co_return;
    }
    const std::string dataset = co_await enter(channel);
    if (dataset.empty() || words == 2) co_return;
    co_await sent(channel, request(dataset, 1));
    co_await sleep(std::chrono::milliseconds(random_() % 200));
  }

  asio::awaitable<void> send_garbage(ChannelPtr channel) {
    const bool is_message = random_() % 2 == 0;
    for (;;) {
      std::string noise = random_bytes(random_, 1 + random_() % 4000);
      const bool is_sent = is_message ? co_await sent_content(channel, std::move(noise))
                                      : co_await sent_raw(channel, std::move(noise));
      if (!is_sent || Clock::now() >= options_.stop) {
        if (!is_sent) ++counts_.ended_by_server;
        co_return;
      }
      co_await sleep(std::chrono::milliseconds(100));
    }
  }

  // Requests simplified surfaces that are not cached, and estimates at the same time.
  asio::awaitable<void> overload(ChannelPtr channel) {
    const std::string dataset = co_await enter(channel);
    if (dataset.empty()) {
      ++counts_.ended_by_server;
      co_return;
    }
    for (std::uint64_t id = 1; Clock::now() < options_.stop;) {
      OpenStream stream = request(dataset, id);
      stream.request.simplify = true;
      bool is_sent = true;
      for (int i = 0; i <= kEstimates && is_sent; ++i, ++id) {
        stream.request.isovalue =
            isovalue_ + 1e-7 * range_ * static_cast<double>(random_() % 1'000'000);
        const Estimate estimate = {.request_id = id, .dataset = dataset, .request = stream.request};
        is_sent = i == 0 ? co_await sent(channel, stream) : co_await sent(channel, estimate);
      }
      for (int open = kEstimates + 1; is_sent && open > 0;) {
        const auto content = co_await channel->receive();
        is_sent = content.has_value();
        if (!is_sent) break;
        const auto message = parse_server_message(*content);
        if (message && is_final_answer(*message)) --open;
        if (message && std::holds_alternative<ErrorReply>(*message)) {
          co_await sleep(std::chrono::milliseconds(200 + random_() % 200));
        }
      }
      if (!is_sent) {
        if (Clock::now() < options_.stop) ++counts_.ended_by_server;
        co_return;
      }
    }
  }

  asio::awaitable<void> hoard(ChannelPtr channel) {
    const std::string dataset = co_await enter(channel);
    if (dataset.empty()) {
      ++counts_.ended_by_server;
      co_return;
    }
    OpenStream stream = request(dataset, 1);
    stream.request.thresholds = largest_map();
    const Estimate estimate = {.request_id = 2, .dataset = dataset, .request = stream.request};
    bool is_sent = co_await sent(channel, stream);
    for (int i = 0; i < kEstimates && is_sent; ++i) is_sent = co_await sent(channel, estimate);
    ListDatasets list;
    for (list.request_id = 3; is_sent && Clock::now() < options_.stop; ++list.request_id) {
      is_sent = co_await sent(channel, list);
      co_await sleep(std::chrono::milliseconds(100));
    }
    if (!is_sent && Clock::now() < options_.stop) ++counts_.ended_by_server;
  }

  [[nodiscard]] static bool is_final_answer(const ServerMessage& message) {
    return std::holds_alternative<StreamEnd>(message) ||
           std::holds_alternative<EstimateReply>(message) ||
           std::holds_alternative<ErrorReply>(message);
  }

  asio::awaitable<bool> sent(ChannelPtr channel, ClientMessage message) {
    return sent_content(std::move(channel), serialize(message));
  }
  asio::awaitable<bool> sent_content(ChannelPtr channel, std::string content) {
    counts_.bytes_sent += content.size();
    const auto done = co_await channel->send(std::move(content));
    co_return done.has_value();
  }
  asio::awaitable<bool> sent_raw(ChannelPtr channel, std::string bytes) {
    counts_.bytes_sent += bytes.size();
    const auto done = co_await channel->send_bytes(std::move(bytes));
    co_return done.has_value();
  }

  asio::awaitable<void> sleep(std::chrono::milliseconds time) {
    co_await sleep_until(Clock::now() + time);
  }
  asio::awaitable<void> sleep_until(Clock::time_point time) {
    timer_.expires_at(std::min(time, options_.stop));
    error_code ignored;
    co_await timer_.async_wait(use_error(ignored));
  }

  // The most that a server computes at once for one connection.
  static constexpr int kEstimates = 4;

  Misbehaviour kind_;
  const UserOptions& options_;
  std::mt19937_64 random_;
  std::string from_;
  MisbehaviourCounts& counts_;
  asio::any_io_executor executor_;
  asio::steady_timer timer_;
  double isovalue_ = 0;
  double range_ = 0;
};

}  // namespace

std::optional<Misbehaviour> misbehaviour_from(std::string_view name) { return kNames.find(name); }

std::string_view name(Misbehaviour kind) { return kNames.of(kind); }

void MisbehaviourCounts::add(const MisbehaviourCounts& other) {
  connections += other.connections;
  failed_attempts += other.failed_attempts;
  ended_by_server += other.ended_by_server;
  bytes_sent += other.bytes_sent;
}

asio::awaitable<void> misbehave(Misbehaviour kind, const UserOptions& options, std::uint64_t seed,
                                std::chrono::milliseconds delay, std::string from,
                                MisbehaviourCounts& counts) {
  const auto executor = co_await asio::this_coro::executor;
  MisbehavingClient client(kind, options, seed, std::move(from), counts, executor);
  co_await client.run(delay);
}

}  // namespace multitetra
