// The service over real connections on this machine, with step sources controlled by the tests.
#include "server/transport/server.hpp"

#include <atomic>
#include <chrono>
#include <csignal>
#include <mutex>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "common/net/net.hpp"
#include "tests/support/fake_steps.hpp"
#include "tests/support/running_server.hpp"
#include "tests/support/waiting.hpp"

namespace multitetra {
namespace {

using namespace std::chrono_literals;
using testing::catalogue_of;
using testing::eventually;
using testing::fake_catalogue;
using testing::FakeSteps;
using testing::is_closed_by_server;
using testing::octahedron_step;
using testing::open_fake;
using testing::receive;
using testing::RunningServer;

// Reads one whole stream, returns its end and counts its steps.
StreamEnd read_stream(MessageSocket& socket, std::uint32_t& steps) {
  steps = 0;
  for (;;) {
    const auto message = socket.receive();
    if (!message) {
      ADD_FAILURE() << message.error().text;
      return {};
    }
    if (const auto* end = std::get_if<StreamEnd>(&*message)) return *end;
    if (std::holds_alternative<StepEnd>(*message)) ++steps;
  }
}

// ---- successful conversations

TEST(Server, StreamsAllStepsOfARequest) {
  RunningServer server(fake_catalogue());
  MessageSocket socket = server.greet();
  ASSERT_TRUE(socket.send(open_fake(1, "fake", StepPolicy::kProgressive)));
  std::uint32_t steps = 0;
  const StreamEnd end = read_stream(socket, steps);
  EXPECT_EQ(end.outcome, StreamOutcome::kComplete);
  EXPECT_EQ(end.steps, steps);
  EXPECT_GE(steps, 2U);
}

TEST(Server, ContinuesAfterAnInvalidRequest) {
  RunningServer server(fake_catalogue());
  MessageSocket socket = server.greet();
  OpenStream unknown = open_fake(1);
  unknown.dataset = "nothing";
  ASSERT_TRUE(socket.send(unknown));
  EXPECT_EQ(receive<ErrorReply>(socket).error.code, ErrorCode::kUnknownDataset);
  ASSERT_TRUE(socket.send(Ping{5}));
  EXPECT_EQ(receive<Pong>(socket).value, 5U);
  ASSERT_TRUE(socket.send(open_fake(2)));
  std::uint32_t steps = 0;
  EXPECT_EQ(read_stream(socket, steps).outcome, StreamOutcome::kComplete);
}

TEST(Server, ServesManyClientsConcurrently) {
  RunningServer server(fake_catalogue());
  std::vector<std::thread> clients;
  for (int i = 0; i < 8; ++i) {
    clients.emplace_back([&server] {
      MessageSocket socket = server.greet();
      for (std::uint64_t id = 1; id <= 5; ++id) {
        ASSERT_TRUE(socket.send(open_fake(id, "fake", StepPolicy::kProgressive)));
        std::uint32_t steps = 0;
        EXPECT_EQ(read_stream(socket, steps).outcome, StreamOutcome::kComplete);
      }
    });
  }
  for (std::thread& client : clients) client.join();
}

TEST(Server, FailsOnlyTheStreamOfAFailedStep) {
  std::atomic<int> calls = 0;
  RunningServer server(catalogue_of(std::make_shared<FakeSteps>(
      "fake", [&calls](const StepRequest& step, const std::stop_token&) {
        if (calls++ == 0) throw std::runtime_error("the disk is gone");
        return octahedron_step(step);
      })));
  MessageSocket socket = server.greet();
  ASSERT_TRUE(socket.send(open_fake(1)));
  const ErrorReply reply = receive<ErrorReply>(socket);
  EXPECT_EQ(reply.request_id, 1U);
  EXPECT_EQ(reply.error.code, ErrorCode::kInternal);
  EXPECT_EQ(reply.error.text.find("disk"), std::string::npos) << "inner matters stay in the log";
  ASSERT_TRUE(socket.send(open_fake(2)));
  std::uint32_t steps = 0;
  EXPECT_EQ(read_stream(socket, steps).outcome, StreamOutcome::kComplete);
}

// ---- stopping during work

TEST(Server, StopsWorkOnCancel) {
  testing::Count running;
  RunningServer server(
      catalogue_of(std::make_shared<FakeSteps>("fake", testing::endless(running))));
  MessageSocket socket = server.greet();
  ASSERT_TRUE(socket.send(open_fake(1)));
  ASSERT_TRUE(running.reaches(1));
  ASSERT_TRUE(socket.send(Cancel{1}));
  const StreamEnd end = receive<StreamEnd>(socket);
  EXPECT_EQ(end.outcome, StreamOutcome::kCancelled);
  EXPECT_EQ(end.steps, 0U);
  EXPECT_TRUE(running.reaches(0));
}

TEST(Server, SupersedesTheRunningStream) {
  testing::Count running;
  const auto endless = testing::endless(running);
  RunningServer server(catalogue_of(std::make_shared<FakeSteps>(
      "fake", [endless](const StepRequest& step, const std::stop_token& stop) {
        return step.request.isovalue == 1 ? endless(step, stop) : octahedron_step(step);
      })));
  MessageSocket socket = server.greet();
  ASSERT_TRUE(socket.send(open_fake(1)));
  ASSERT_TRUE(running.reaches(1));
  OpenStream second = open_fake(2);
  second.request.isovalue = 2;
  ASSERT_TRUE(socket.send(second));
  EXPECT_EQ(receive<StreamEnd>(socket).outcome, StreamOutcome::kSuperseded);
  EXPECT_EQ(receive<StepBegin>(socket).request_id, 2U);
  std::uint32_t steps = 0;
  EXPECT_EQ(read_stream(socket, steps).request_id, 2U);
}

// The only worker is freed by the request that waits for it.
TEST(Server, ServesTwoClientsWithOneWorkerWhileOneSupersedes) {
  testing::Count running;
  const auto endless = testing::endless(running);
  RunningServer server(catalogue_of(std::make_shared<FakeSteps>(
                           "fake",
                           [endless](const StepRequest& step, const std::stop_token& stop) {
                             return step.request.isovalue == 1 ? endless(step, stop)
                                                               : octahedron_step(step);
                           })),
                       {.service = {.workers = 1}});
  const auto brief = [](std::uint64_t id) {
    OpenStream request = open_fake(id, "fake", StepPolicy::kProgressive);
    request.request.isovalue = 2;
    return request;
  };
  MessageSocket first = server.greet();
  MessageSocket second = server.greet();
  ASSERT_TRUE(first.send(open_fake(1)));
  ASSERT_TRUE(running.reaches(1));
  ASSERT_TRUE(second.send(brief(1)));
  ASSERT_TRUE(second.send(brief(2)));
  EXPECT_EQ(receive<StreamEnd>(second).outcome, StreamOutcome::kSuperseded);
  for (std::uint64_t id = 2; id <= 20; ++id) ASSERT_TRUE(first.send(brief(id)));
  std::uint32_t steps = 0;
  for (std::uint64_t id = 1; id < 20; ++id) {
    EXPECT_EQ(read_stream(first, steps).request_id, id);
  }
  EXPECT_EQ(read_stream(first, steps).outcome, StreamOutcome::kComplete);
  EXPECT_EQ(read_stream(second, steps).outcome, StreamOutcome::kComplete);
}

// The stream is superseded between two tiles while the client reads slowly.
TEST(Server, EndsASupersededStepWithinAFewTiles) {
  constexpr std::size_t kTiles = 2000;
  RunningServer server(
      catalogue_of(std::make_shared<FakeSteps>("fake", testing::heavy(kTiles, 64 * 1024))),
      {.connection = {.send_buffer_bytes = 64 * 1024}});
  MessageSocket socket = server.greet();
  ASSERT_TRUE(socket.send(open_fake(1)));
  (void)receive<StepBegin>(socket);
  (void)receive<Tile>(socket);
  ASSERT_TRUE(socket.send(open_fake(2)));
  std::size_t tiles = 1;
  for (;;) {
    const auto message = socket.receive();
    ASSERT_TRUE(message);
    if (const auto* end = std::get_if<StreamEnd>(&*message)) {
      EXPECT_EQ(end->request_id, 1U);
      EXPECT_EQ(end->outcome, StreamOutcome::kSuperseded);
      break;
    }
    ASSERT_TRUE(std::holds_alternative<Tile>(*message));
    ++tiles;
  }
  EXPECT_LT(tiles, kTiles);
  EXPECT_EQ(receive<StepBegin>(socket).request_id, 2U);
}

TEST(Server, StopsWorkWhenTheClientDisconnects) {
  testing::Count running;
  RunningServer server(
      catalogue_of(std::make_shared<FakeSteps>("fake", testing::endless(running))));
  {
    MessageSocket socket = server.greet();
    ASSERT_TRUE(socket.send(open_fake(1)));
    ASSERT_TRUE(running.reaches(1));
  }
  EXPECT_TRUE(running.reaches(0));
}

TEST(Server, StopsWithConnectionsInEveryState) {
  testing::Count running;
  RunningServer server(catalogue_of(std::make_shared<FakeSteps>("fake", testing::endless(running))),
                       {.connection = {.linger = 200ms}});
  MessageSocket silent = server.connect();
  MessageSocket idle = server.greet();
  MessageSocket working = server.greet();
  ASSERT_TRUE(working.send(open_fake(1)));
  MessageSocket half = server.greet();
  ASSERT_TRUE(half.send_bytes("\x10"));
  ASSERT_TRUE(running.reaches(1));
  const auto start = std::chrono::steady_clock::now();
  server.stop();
  EXPECT_LT(std::chrono::steady_clock::now() - start, 10s);
  EXPECT_EQ(running, 0);
  EXPECT_EQ(receive<ErrorReply>(idle).error.code, ErrorCode::kUnavailable);
  EXPECT_TRUE(is_closed_by_server(idle));
  // The client did not cancel its stream: clients and gateways retry after kUnavailable.
  const ErrorReply of_stream = receive<ErrorReply>(working);
  EXPECT_EQ(of_stream.request_id, 1U);
  EXPECT_EQ(of_stream.error.code, ErrorCode::kUnavailable);
  EXPECT_EQ(receive<ErrorReply>(working).request_id, 0U);
}

TEST(Server, StopsWhileAClientDoesNotRead) {
  RunningServer server(
      catalogue_of(std::make_shared<FakeSteps>("fake", testing::heavy(1000, 256 * 1024))),
      {.connection = {.linger = 100ms}});
  MessageSocket socket = server.greet();
  ASSERT_TRUE(socket.send(open_fake(1)));
  (void)receive<StepBegin>(socket);
  const auto start = std::chrono::steady_clock::now();
  server.stop();
  EXPECT_LT(std::chrono::steady_clock::now() - start, 10s);
}

TEST(Server, StopsDuringAReload) {
  for (int round = 0; round < 20; ++round) {
    RunningServer server(fake_catalogue(), {.handles_signals = true});
    // A server that has answered handles signals.
    EXPECT_TRUE(server.greet().send(ListDatasets{}));
    std::raise(SIGTERM);
    std::raise(SIGHUP);
    server.wait();
  }
}

// ---- misbehaving clients

TEST(Server, ClosesWithAReasonAfterInvalidBytes) {
  RunningServer server(fake_catalogue());
  MessageSocket socket = server.greet();
  ASSERT_TRUE(socket.send_bytes(frame_header(12) + "no protobuf!"));
  EXPECT_EQ(receive<ErrorReply>(socket).error.code, ErrorCode::kMalformedMessage);
  EXPECT_TRUE(is_closed_by_server(socket));
}

TEST(Server, ClosesOnTheHeaderOfAnOversizedFrame) {
  RunningServer server(fake_catalogue());
  MessageSocket socket = server.greet();
  ASSERT_TRUE(socket.send_bytes(frame_header(kMaxClientFrameBytes + 1)));
  EXPECT_EQ(receive<ErrorReply>(socket).error.code, ErrorCode::kMessageTooLarge);
  EXPECT_TRUE(is_closed_by_server(socket));
}

TEST(Server, LimitsFramesBeforeHello) {
  RunningServer server(fake_catalogue());
  MessageSocket socket = server.connect();
  ASSERT_TRUE(socket.send_bytes(frame_header(kMaxHelloFrameBytes + 1)));
  EXPECT_EQ(receive<ErrorReply>(socket).error.code, ErrorCode::kMessageTooLarge);
  EXPECT_TRUE(is_closed_by_server(socket));
}

// An HTTP request read as a frame has a length of more than a gigabyte.
TEST(Server, RejectsOtherProtocolsWithAReason) {
  RunningServer server(fake_catalogue());
  MessageSocket socket = server.connect();
  ASSERT_TRUE(socket.send_bytes("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"));
  const Error refusal = receive<ErrorReply>(socket).error;
  EXPECT_EQ(refusal.code, ErrorCode::kMalformedFrame);
  EXPECT_NE(refusal.text.find("received an HTTP request"), std::string::npos) << refusal.text;
  EXPECT_TRUE(is_closed_by_server(socket));
}

TEST(Server, SurvivesADisconnectInsideAFrame) {
  RunningServer server(fake_catalogue());
  for (int i = 0; i < 10; ++i) {
    MessageSocket socket = server.greet();
    ASSERT_TRUE(socket.send_bytes(frame_header(100) + "only a part"));
  }
  MessageSocket socket = server.greet();
  ASSERT_TRUE(socket.send(Ping{1}));
  EXPECT_EQ(receive<Pong>(socket).value, 1U);
}

TEST(Server, ClosesClientsWithoutHello) {
  RunningServer server(fake_catalogue(), {.connection = {.handshake_timeout = 50ms}});
  MessageSocket socket = server.connect();
  EXPECT_EQ(receive<ErrorReply>(socket).error.code, ErrorCode::kUnavailable);
  EXPECT_TRUE(is_closed_by_server(socket));
}

TEST(Server, LimitsConnections) {
  RunningServer server(fake_catalogue(), {.admission = {.connections = {.total = 2}},
                                          .connection = {.linger = 10ms}});
  MessageSocket first = server.greet();
  {
    MessageSocket second = server.greet();
    MessageSocket third = server.connect();
    EXPECT_EQ(receive<ErrorReply>(third).error.code, ErrorCode::kUnavailable);
    EXPECT_TRUE(is_closed_by_server(third));
  }
  EXPECT_TRUE(eventually([&] {
    MessageSocket again = server.connect();
    if (!again.send(Hello{})) return false;
    const auto answer = again.receive();
    return answer && std::holds_alternative<Welcome>(*answer);
  }));
}

// A step is made only after the client has taken the one before, and no worker waits meanwhile:
// with one worker and a client that does not read, another client is served.
TEST(Server, BuffersOneStepForAClientThatDoesNotRead) {
  std::atomic<int> made = 0;
  const auto heavy = testing::heavy(64, 1024 * 1024);
  RunningServer server(catalogue_of(std::make_shared<FakeSteps>(
                           "fake",
                           [&made, heavy](const StepRequest& step, const std::stop_token& stop) {
                             if (step.request.isovalue != 1) return octahedron_step(step);
                             ++made;
                             return heavy(step, stop);
                           })),
                       {.service = {.workers = 1}});
  MessageSocket stalled = server.greet();
  ASSERT_TRUE(stalled.send(open_fake(1, "fake", StepPolicy::kProgressive)));
  ASSERT_TRUE(eventually([&] { return made == 1; }));

  MessageSocket other = server.greet();
  OpenStream request = open_fake(1, "fake", StepPolicy::kProgressive);
  request.request.isovalue = 2;
  ASSERT_TRUE(other.send(request));
  std::uint32_t steps = 0;
  EXPECT_EQ(read_stream(other, steps).outcome, StreamOutcome::kComplete);
  // If another step of the stalled client were queued, the only worker would make it first, as the
  // other client has used more time.
  request.request_id = 2;
  ASSERT_TRUE(other.send(request));
  EXPECT_EQ(read_stream(other, steps).outcome, StreamOutcome::kComplete);
  EXPECT_EQ(made, 1) << "a step was made ahead of a client that does not read";
}

TEST(Server, BuildsStepsWithoutAWaitingClientLast) {
  testing::Gate has_begun;
  testing::Gate may_end;
  std::mutex mutex;
  std::vector<double> made;
  RunningServer server(catalogue_of(std::make_shared<FakeSteps>(
                           "fake",
                           [&](const StepRequest& step, const std::stop_token& stop) {
                             if (step.request.isovalue == 0) {
                               has_begun.open();
                               may_end.pass(stop);
                             }
                             const std::lock_guard lock(mutex);
                             made.push_back(step.request.isovalue);
                             return octahedron_step(step);
                           })),
                       {.service = {.workers = 1}});
  std::vector<MessageSocket> clients;
  const auto request = [&](double isovalue, Priority priority) {
    clients.push_back(server.greet());
    OpenStream open = open_fake(1);
    open.request.isovalue = isovalue;
    open.priority = priority;
    ASSERT_TRUE(clients.back().send(open));
    ASSERT_TRUE(clients.back().send(Ping{1}));  // The answer arrives when the stream waits for the
                                                // worker.
    (void)receive<Pong>(clients.back());
  };
  request(0, Priority::kNormal);
  ASSERT_TRUE(has_begun.pass());
  request(1, Priority::kBackground);
  request(2, Priority::kNormal);
  may_end.open();
  std::uint32_t steps = 0;
  for (MessageSocket& client : clients) {
    EXPECT_EQ(read_stream(client, steps).outcome, StreamOutcome::kComplete);
  }
  EXPECT_EQ(made, (std::vector<double>{0, 2, 1}));
}

TEST(Server, ClosesClientsThatDoNotReadAfterTheWriteTimeout) {
  std::atomic<int> left = 0;
  RunningServer server(
      catalogue_of(std::make_shared<FakeSteps>("fake", testing::heavy(64, 1024 * 1024))),
      {.admission = {.connections = {.total = 1}},
       .connection = {.write_timeout = 200ms, .linger = 10ms, .send_buffer_bytes = 64 * 1024}});
  MessageSocket stalled = server.greet();
  ASSERT_TRUE(stalled.send(open_fake(1)));
  EXPECT_TRUE(eventually([&] {
    MessageSocket next = server.connect();
    if (!next.send(Hello{})) return false;
    const auto answer = next.receive();
    return answer && std::holds_alternative<Welcome>(*answer);
  }));
}

// The server stops reading from a client that does not read its replies: the client's writes stall
// before the server has received much.
TEST(Server, LimitsUnreadReplies) {
  RunningServer server(fake_catalogue(), {.connection = {.send_buffer_bytes = 16 * 1024}});
  asio::io_context io;
  tcp::socket socket(io);
  socket.open(tcp::v4());
  socket.set_option(asio::socket_base::receive_buffer_size(16 * 1024));
  socket.connect({asio::ip::make_address("127.0.0.1"), server.endpoint().port});
  const auto framed = [](const ClientMessage& message) {
    const std::string content = serialize(message);
    return frame_header(static_cast<std::uint32_t>(content.size())) + content;
  };
  asio::write(socket, asio::buffer(framed(Hello{})));
  std::string lists;
  for (std::uint64_t i = 1; i <= 1000; ++i) lists += framed(ListDatasets{i});
  socket.non_blocking(true);
  std::size_t sent = 0;
  int stalls = 0;
  constexpr std::size_t kFarTooMuch = 64 * 1024 * 1024;
  while (stalls < 200 && sent < kFarTooMuch) {
    boost::system::error_code error;
    const std::size_t size = socket.write_some(asio::buffer(lists), error);
    // After a partial write the rest of the frame must follow first.
    sent += size;
    if (error == asio::error::would_block) {
      ++stalls;
      std::this_thread::sleep_for(1ms);
      continue;
    }
    ASSERT_FALSE(error) << error.message();
    stalls = 0;
    if (size < lists.size()) {
      lists = lists.substr(size) + lists.substr(0, size);
    }
  }
  EXPECT_LT(sent, kFarTooMuch) << "the server read on though its replies were not read";
}

// The serialized histogram alone is longer than the largest frame.
class OversizedInfo : public FakeSteps {
 public:
  explicit OversizedInfo(testing::MakeStep make) : FakeSteps("fake", std::move(make)) {
    info_ = testing::octahedra_info("fake");
    info_.histogram.counts.assign(kMaxServerFrameBytes / 8, ~std::uint64_t{0});
  }
  [[nodiscard]] const DatasetInfo& info() const override { return info_; }

 private:
  DatasetInfo info_;
};

TEST(Server, RejectsTooLongListsAndKeepsTheRunningStream) {
  testing::Count running;
  RunningServer server(catalogue_of(std::make_shared<OversizedInfo>(testing::endless(running))));
  MessageSocket socket = server.greet();
  ASSERT_TRUE(socket.send(open_fake(1)));
  ASSERT_TRUE(running.reaches(1));
  ASSERT_TRUE(socket.send(ListDatasets{9}));
  const ErrorReply reply = receive<ErrorReply>(socket);
  EXPECT_EQ(reply.request_id, 9U);
  EXPECT_EQ(reply.error.code, ErrorCode::kLimitExceeded);
  EXPECT_EQ(running, 1);
  ASSERT_TRUE(socket.send(Cancel{1}));
  EXPECT_EQ(receive<StreamEnd>(socket).outcome, StreamOutcome::kCancelled);
}

// Fails for the first client, like a log on a full disk.
class FailingOnce : public ServiceObserver {
 public:
  void connected(const ClientFacts&) override {
    if (!std::exchange(has_failed_, true)) throw std::runtime_error("the disk is full");
  }

 private:
  bool has_failed_ = false;
};

TEST(Server, AcceptsClientsAfterAFailedOne) {
  RunningServer server(fake_catalogue(),
                       {.admission = {.observer = std::make_shared<FailingOnce>()}});
  MessageSocket unlucky = server.connect();
  EXPECT_TRUE(is_closed_by_server(unlucky));
  MessageSocket next = server.greet();
  ASSERT_TRUE(next.send(Ping{1}));
  EXPECT_EQ(receive<Pong>(next).value, 1U);
}

TEST(Server, NamesAnAddressThatIsInUse) {
  RunningServer server(fake_catalogue());
  try {
    Server second(fake_catalogue(), {.listen = server.endpoint()});
    FAIL() << "two servers on one port";
  } catch (const std::runtime_error& error) {
    const std::string address = "127.0.0.1:" + std::to_string(server.endpoint().port);
    EXPECT_NE(std::string(error.what()).find(address), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("--tcp off"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace multitetra
