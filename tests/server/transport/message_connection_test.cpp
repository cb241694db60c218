// A connection without a network and in simulated time: the test is both the client and the clock.
#include "server/transport/message_connection.hpp"

#include <deque>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "common/net/async_event.hpp"
#include "server/service/local_service.hpp"
#include "tests/support/fake_steps.hpp"

namespace multitetra {
namespace {

using namespace std::chrono_literals;
using testing::fake_catalogue;

// The messages that a client sends and receives.
struct Client {
  explicit Client(asio::io_context& io) : some_output(io.get_executor()) {}

  std::deque<ClientMessage> says;
  std::vector<ServerMessage> heard;
  bool is_gone = false;
  AsyncEvent some_output;
};

class MemoryTransport : public MessageTransport {
 public:
  explicit MemoryTransport(Client& client) : client_(client) {}

  asio::awaitable<Result<std::string>> receive() override {
    while (client_.says.empty() && !client_.is_gone) co_await client_.some_output.wait();
    if (client_.is_gone) co_return fail(ErrorCode::kUnavailable, "the client is gone");
    const ClientMessage message = std::move(client_.says.front());
    client_.says.pop_front();
    co_return serialize(message);
  }
  asio::awaitable<Result<std::size_t>> send(std::string content) override {
    client_.heard.push_back(parse_server_message(content).value());
    co_return content.size();
  }
  asio::awaitable<void> drain() override { co_return; }
  asio::awaitable<void> close_gracefully() override { co_return; }
  void set_limit(std::uint32_t) override {}
  bool was_cut_off() const override { return false; }

 private:
  Client& client_;
};

class MessageConnectionTest : public ::testing::Test {
 protected:
  MessageConnectionTest() { set_log_level(LogLevel::kOff); }
  ~MessageConnectionTest() override {
    client_.is_gone = true;
    client_.some_output.notify_all();
    run();
    EXPECT_TRUE(is_closed_);
    service_.workers().join();
  }

  void start(std::chrono::milliseconds idle_time = {}) {
    const ConnectionContextPtr context = admission_.admit("tcp", "127.0.0.1", "test").client;
    auto session =
        std::make_shared<SessionRunner>(io_.get_executor(), service_.open(context),
                                        Session(fake_catalogue(), {}), context, idle_time);
    connection_ = std::make_shared<MessageConnection>(
        std::make_unique<ByteStream>(tcp::socket(io_)),
        [this](ByteStream&,
               TransportOptions) -> asio::awaitable<Result<std::unique_ptr<MessageTransport>>> {
          co_return std::make_unique<MemoryTransport>(client_);
        },
        context, std::move(session), options_);
    connection_->start([this] { is_closed_ = true; });
    run();
  }
  void say(ClientMessage message) {
    client_.says.push_back(std::move(message));
    client_.some_output.notify_all();
    run();
  }
  void enforce_limits(Clock::duration from_now) {
    connection_->enforce_limits(Clock::now() + from_now);
    run();
  }
  template <typename Message>
  [[nodiscard]] bool heard_last() const {
    return !client_.heard.empty() && std::holds_alternative<Message>(client_.heard.back());
  }

  const ConnectionOptions options_{.handshake_timeout = 10s};
  AdmissionControl admission_{{}};
  asio::io_context io_{1};
  LocalService service_{io_.get_executor(), fake_catalogue(), {.workers = 1}};
  Client client_{io_};
  std::shared_ptr<MessageConnection> connection_;
  bool is_closed_ = false;

 private:
  void run() {
    io_.restart();
    io_.poll();
  }
};

TEST_F(MessageConnectionTest, ReportsAReasonWithoutHello) {
  start();
  enforce_limits(9s);
  EXPECT_TRUE(client_.heard.empty());
  enforce_limits(11s);
  ASSERT_TRUE(heard_last<ErrorReply>());
  EXPECT_EQ(std::get<ErrorReply>(client_.heard.back()).error.code, ErrorCode::kUnavailable);
}

TEST_F(MessageConnectionTest, KeepsWelcomedIdleClients) {
  start();
  say(Hello{});
  ASSERT_TRUE(heard_last<Welcome>());
  enforce_limits(11s);
  enforce_limits(24h);
  EXPECT_TRUE(heard_last<Welcome>());
  say(Ping{7});
  ASSERT_TRUE(heard_last<Pong>());
}

TEST_F(MessageConnectionTest, DisconnectsOnlyIdleClientsAtTheIdleLimit) {
  start(60s);
  say(Hello{});
  enforce_limits(59s);
  EXPECT_TRUE(heard_last<Welcome>());
  say(Ping{7});
  ASSERT_TRUE(heard_last<Pong>());
  enforce_limits(61s);
  ASSERT_TRUE(heard_last<ErrorReply>());
  EXPECT_EQ(std::get<ErrorReply>(client_.heard.back()).error.code, ErrorCode::kUnavailable);
}

TEST(IdleWatch, CountsFromTheLastActivity) {
  const IdleWatch::Clock::time_point start{};
  IdleWatch watch(10s, start);
  EXPECT_FALSE(watch.is_exceeded(start + 9s, false));
  watch.record_activity(start + 5s);
  EXPECT_FALSE(watch.is_exceeded(start + 14s, false));
  EXPECT_FALSE(watch.is_exceeded(start + 20s, true));
  EXPECT_FALSE(watch.is_exceeded(start + 29s, false));
  EXPECT_TRUE(watch.is_exceeded(start + 30s, false));
  EXPECT_FALSE(IdleWatch(0s, start).is_exceeded(start + 1000h, false));
}

}  // namespace
}  // namespace multitetra
