// Limits of a server on a network: rights, rates, memory, and shutdown.
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>

#include <gtest/gtest.h>

#include "common/base/exit_codes.hpp"
#include "common/net/stream_socket.hpp"
#include "tests/support/certificates.hpp"
#include "tests/support/fake_steps.hpp"
#include "tests/support/running_server.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/waiting.hpp"

namespace multitetra {
namespace {

using namespace std::chrono_literals;
using testing::catalogue_of;
using testing::endless;
using testing::eventually;
using testing::fake_catalogue;
using testing::FakeSteps;
using testing::heavy;
using testing::is_closed_by_server;
using testing::open_fake;
using testing::receive;
using testing::RunningServer;
using testing::self_signed;

CataloguePtr two_datasets() {
  auto catalogue = catalogue_of(std::make_shared<FakeSteps>("head"));
  catalogue->add(std::make_shared<FakeSteps>("secret"));
  return catalogue;
}

// Skips the messages of steps; returns the next StreamEnd or error.
ServerMessage after_steps(MessageSocket& socket) {
  for (;;) {
    auto message = socket.receive();
    if (!message) return ErrorReply{.error = message.error()};
    if (std::holds_alternative<StreamEnd>(*message) || std::holds_alternative<ErrorReply>(*message))
      return *std::move(message);
  }
}

Error error_of(const ServerMessage& message) {
  const auto* reply = std::get_if<ErrorReply>(&message);
  return reply == nullptr ? Error{} : reply->error;
}

// Records all events.
class Notes : public ServiceObserver {
 public:
  void refused(const ClientFacts&, const char* limit) override { add(limit); }
  void request_ended(const ClientFacts& client, const RequestFacts& facts) override {
    add(std::string(facts.kind) + " " + std::string(facts.outcome));
    const std::lock_guard lock(mutex_);
    last_ = facts;
    client_ = client;
  }
  [[nodiscard]] bool has(const std::string& note) const {
    const std::lock_guard lock(mutex_);
    return std::find(notes_.begin(), notes_.end(), note) != notes_.end();
  }
  [[nodiscard]] RequestFacts last() const {
    const std::lock_guard lock(mutex_);
    return last_;
  }
  [[nodiscard]] ClientFacts client() const {
    const std::lock_guard lock(mutex_);
    return client_;
  }

 private:
  void add(std::string note) {
    const std::lock_guard lock(mutex_);
    notes_.push_back(std::move(note));
  }

  mutable std::mutex mutex_;  // Guards the members below.
  std::vector<std::string> notes_;
  RequestFacts last_;
  ClientFacts client_;
};

// ---- tokens

class TokensTest : public ::testing::Test {
 protected:
  void write(const std::string& lines) { file_ = folder_.file("tokens", lines); }
  [[nodiscard]] ServerOptions options() const { return {.admission = {.tokens = file_}}; }
  static MessageSocket greet_with(const RunningServer& server, const std::string& token) {
    MessageSocket socket = server.connect();
    EXPECT_TRUE(socket.send(Hello{.token = token}));
    return socket;
  }

  TemporaryFolder folder_;
  std::filesystem::path file_;
};

TEST_F(TokensTest, ClosesConnectionsWithUnknownTokens) {
  write(access_line("alice", "right", {"*"}));
  const RunningServer server(two_datasets(), options());
  for (const std::string& token : std::vector<std::string>{"", "wrong"}) {
    MessageSocket socket = greet_with(server, token);
    EXPECT_EQ(receive<ErrorReply>(socket).error.code, ErrorCode::kUnauthenticated);
    EXPECT_TRUE(is_closed_by_server(socket));
  }
  MessageSocket socket = greet_with(server, "right");
  (void)receive<Welcome>(socket);
}

TEST_F(TokensTest, ReportsDatasetsWithoutRightsAsUnknown) {
  write(access_line("alice", "right", {"hea?"}));
  const RunningServer server(two_datasets(), options());
  MessageSocket socket = greet_with(server, "right");
  (void)receive<Welcome>(socket);
  ASSERT_TRUE(socket.send(ListDatasets{1}));
  const DatasetList list = receive<DatasetList>(socket);
  ASSERT_EQ(list.datasets.size(), 1U);
  EXPECT_EQ(list.datasets[0].name, "head");
  ASSERT_TRUE(socket.send(open_fake(1, "secret")));
  const Error hidden = receive<ErrorReply>(socket).error;
  ASSERT_TRUE(socket.send(open_fake(1, "nowhere")));
  const Error absent = receive<ErrorReply>(socket).error;
  EXPECT_EQ(hidden.code, ErrorCode::kUnknownDataset);
  EXPECT_EQ(hidden.text.size() - std::string("secret").size(),
            absent.text.size() - std::string("nowhere").size());
  ASSERT_TRUE(socket.send(Estimate{.request_id = 2, .dataset = "secret"}));
  EXPECT_EQ(receive<ErrorReply>(socket).error.code, ErrorCode::kUnknownDataset);
  ASSERT_TRUE(socket.send(open_fake(3, "head")));
  EXPECT_TRUE(std::holds_alternative<StreamEnd>(after_steps(socket)));
}

TEST_F(TokensTest, AppliesAReloadToNewAndOpenConnections) {
  write(access_line("alice", "right", {"*"}) + "\n" + access_line("bob", "other", {"*"}));
  RunningServer server(two_datasets(), options());
  MessageSocket alice = greet_with(server, "right");
  (void)receive<Welcome>(alice);
  MessageSocket bob = greet_with(server, "other");
  (void)receive<Welcome>(bob);
  write(access_line("bob", "other", {"head"}) + "\n" + access_line("carol", "new", {"*"}));
  server.reload();
  MessageSocket carol = greet_with(server, "new");
  (void)receive<Welcome>(carol);
  ASSERT_TRUE(bob.send(ListDatasets{1}));
  EXPECT_EQ(receive<DatasetList>(bob).datasets.size(), 1U);
  ASSERT_TRUE(alice.send(ListDatasets{1}));
  EXPECT_EQ(receive<ErrorReply>(alice).error.code, ErrorCode::kUnauthenticated);
  EXPECT_TRUE(is_closed_by_server(alice));
}

TEST_F(TokensTest, KeepsTheOldListAfterABrokenFile) {
  write(access_line("alice", "right", {"*"}));
  RunningServer server(two_datasets(), options());
  write("nonsense\n");
  server.reload();
  MessageSocket alice = greet_with(server, "right");
  (void)receive<Welcome>(alice);
  EXPECT_THROW(Server(two_datasets(), {.listen = {"127.0.0.1", 0}, .admission = {.tokens = file_}}),
               ExitError);
}

// ---- TLS

// A blocking client that exchanges frames over TLS.
class TlsClient {
 public:
  TlsClient(const Endpoint& server, const std::string& trusted) : context_(make(trusted)) {
    stream_.emplace(io_, context_);
    stream_->next_layer().connect({asio::ip::make_address(server.host), server.port});
    stream_->handshake(asio::ssl::stream_base::client);
  }
  ServerMessage exchange(const ClientMessage& message) {
    const std::string content = serialize(message);
    const std::string frame = frame_header(static_cast<std::uint32_t>(content.size())) + content;
    asio::write(*stream_, asio::buffer(frame));
    FrameReader frames(kMaxServerFrameBytes);
    std::array<char, 4096> buffer{};
    for (;;) {
      const auto got = frames.next();
      if (got.value()) return parse_server_message(**got).value();
      frames.feed({buffer.data(), stream_->read_some(asio::buffer(buffer))});
    }
  }

 private:
  static asio::ssl::context make(const std::string& trusted) {
    asio::ssl::context context(asio::ssl::context::tls_client);
    context.add_certificate_authority(asio::buffer(trusted));
    context.set_verify_mode(asio::ssl::verify_peer);
    context.set_verify_callback(asio::ssl::host_name_verification("localhost"));
    return context;
  }

  asio::io_context io_;
  asio::ssl::context context_;
  std::optional<asio::ssl::stream<tcp::socket>> stream_;
};

class TlsTest : public ::testing::Test {
 protected:
  void write(const testing::CertificateAndKey& made) {
    files_ = {.certificate = folder_.file("server.pem", made.certificate),
              .key = folder_.file("server.key", made.key)};
  }
  TemporaryFolder folder_;
  TlsFiles files_;
  testing::CertificateAndKey first_ = self_signed();
  testing::CertificateAndKey second_ = self_signed();
};

TEST_F(TlsTest, ExchangesTheSameMessages) {
  write(first_);
  const RunningServer server(fake_catalogue(), {.admission = {.tls = files_}});
  TlsClient client(server.endpoint(), first_.certificate);
  EXPECT_TRUE(std::holds_alternative<Welcome>(client.exchange(Hello{})));
  EXPECT_TRUE(std::holds_alternative<DatasetList>(client.exchange(ListDatasets{1})));
}

TEST_F(TlsTest, AppliesOnlyValidRenewedCertificatesToNewConnections) {
  write(first_);
  RunningServer server(fake_catalogue(), {.admission = {.tls = files_}});
  TlsClient before(server.endpoint(), first_.certificate);
  write(second_);
  server.reload();
  EXPECT_TRUE(std::holds_alternative<Welcome>(before.exchange(Hello{})));
  EXPECT_NO_THROW(TlsClient(server.endpoint(), second_.certificate));
  EXPECT_THROW(TlsClient(server.endpoint(), first_.certificate), boost::system::system_error);
  write({.certificate = "broken", .key = "broken"});
  server.reload();
  EXPECT_NO_THROW(TlsClient(server.endpoint(), second_.certificate));
}

TEST_F(TlsTest, ClosesConnectionsWithoutAHandshake) {
  write(first_);
  const RunningServer server(
      fake_catalogue(),
      {.admission = {.tls = files_}, .connection = {.handshake_timeout = 50ms, .linger = 10ms}});
  MessageSocket silent = server.connect();
  EXPECT_TRUE(is_closed_by_server(silent));
  MessageSocket plain = server.connect();
  ASSERT_TRUE(plain.send(Hello{}));
  const auto answer = plain.receive();
  EXPECT_FALSE(answer);
}

// ---- limits

TEST(ServerLimits, LimitConnectionsFromOneAddress) {
  const RunningServer server(
      fake_catalogue(),
      {.admission = {.connections = {.total = 10, .per_name = 1}}, .connection = {.linger = 10ms}});
  MessageSocket first = server.greet();
  MessageSocket second = server.connect();
  const Error refused = receive<ErrorReply>(second).error;
  EXPECT_EQ(refused.code, ErrorCode::kUnavailable);
  EXPECT_NE(refused.text.find("from your address"), std::string::npos);
  EXPECT_TRUE(is_closed_by_server(second));
}

MessageSocket greet_from(const RunningServer& server, const std::string& address) {
  auto socket = MessageSocket::connect(server.endpoint(), 30s, {.from = address});
  EXPECT_TRUE(socket) << socket.error().text;
  EXPECT_TRUE(socket->send(Hello{}));
  (void)receive<Welcome>(*socket);
  return *std::move(socket);
}

TEST(ServerLimits, CloseTheLongestIdleConnectionOfTheLargestShare) {
  testing::Count running;
  const RunningServer server(
      catalogue_of(std::make_shared<FakeSteps>("fake", endless(running))),
      {.admission = {.connections = {.total = 4, .per_name = 3}}, .connection = {.linger = 10ms}});
  MessageSocket alone = greet_from(server, "127.0.2.1");  // Idle for longer than any other.
  MessageSocket busy = greet_from(server, "127.0.1.1");
  ASSERT_TRUE(busy.send(open_fake(1)));
  ASSERT_TRUE(eventually([&] { return running == 1; }));
  MessageSocket idle = greet_from(server, "127.0.1.1");
  MessageSocket later = greet_from(server, "127.0.1.1");
  MessageSocket newcomer = greet_from(server, "127.0.3.1");
  const Error ended = receive<ErrorReply>(idle).error;
  EXPECT_EQ(ended.code, ErrorCode::kUnavailable);
  EXPECT_NE(ended.text.find("closes its longest idle connection"), std::string::npos) << ended.text;
  EXPECT_TRUE(is_closed_by_server(idle));
  for (MessageSocket* const stays : {&alone, &busy, &later, &newcomer}) {
    ASSERT_TRUE(stays->send(Ping{1}));
    (void)receive<Pong>(*stays);
  }
}

TEST(ServerLimits, LimitRequestsPerSecondAndKeepTheConnection) {
  const auto notes = std::make_shared<Notes>();
  const RunningServer server(
      fake_catalogue(),
      {.admission = {.requests = {.per_second = 0.001, .burst = 2}, .observer = notes}});
  MessageSocket socket = server.greet();
  for (std::uint64_t id = 1; id <= 2; ++id) {
    ASSERT_TRUE(socket.send(ListDatasets{id}));
    (void)receive<DatasetList>(socket);
  }
  ASSERT_TRUE(socket.send(open_fake(7)));
  const ErrorReply refused = receive<ErrorReply>(socket);
  EXPECT_EQ(refused.error.code, ErrorCode::kLimitExceeded);
  EXPECT_EQ(refused.request_id, 7U);
  ASSERT_TRUE(socket.send(Ping{1}));
  (void)receive<Pong>(socket);
  EXPECT_TRUE(notes->has("requests_per_second"));
}

TEST(ServerLimits, LimitRegionsOfAThresholdMap) {
  const RunningServer server(fake_catalogue(), {.service = {.requests = {.max_regions = 1}}});
  MessageSocket socket = server.greet();
  OpenStream request = open_fake(1);
  request.request.thresholds.regions.resize(2, {.shape = BallShape{.radius = 1}});
  ASSERT_TRUE(socket.send(request));
  const ErrorReply refused = receive<ErrorReply>(socket);
  EXPECT_EQ(refused.error.code, ErrorCode::kLimitExceeded);
  EXPECT_EQ(refused.request_id, 1U);
  request.request.thresholds.regions.pop_back();
  ASSERT_TRUE(socket.send(request));
  EXPECT_TRUE(std::holds_alternative<StreamEnd>(after_steps(socket)));
}

TEST(ServerLimits, LimitTheWorkerTimeOfARequest) {
  testing::Count running;
  const RunningServer server(catalogue_of(std::make_shared<FakeSteps>("fake", endless(running))),
                             {.service = {.workers = 1, .limits = {.request_time = 50ms}}});
  MessageSocket socket = server.greet();
  ASSERT_TRUE(socket.send(open_fake(1)));
  const ErrorReply given_up = receive<ErrorReply>(socket);
  EXPECT_EQ(given_up.error.code, ErrorCode::kLimitExceeded);
  EXPECT_NE(given_up.error.text.find("limit of 0.05 s"), std::string::npos) << given_up.error.text;
  EXPECT_EQ(given_up.request_id, 1U);
  EXPECT_TRUE(running.reaches(0)) << "The worker still works although its client is gone.";
  ASSERT_TRUE(socket.send(Ping{1}));
  (void)receive<Pong>(socket);
}

// Bytes that a request reserves besides its step. A share may take half of the total.
constexpr std::size_t kOfARequest = 4096;

TEST(ServerLimits, LimitBytesThatWaitForClients) {
  const RunningServer server(catalogue_of(std::make_shared<FakeSteps>("fake", heavy(4, 100'000))),
                             {.admission = {.queue_bytes = 2 * (400'000 + kOfARequest) - 2}});
  MessageSocket socket = server.greet();
  ASSERT_TRUE(socket.send(open_fake(1)));
  const Error full = receive<ErrorReply>(socket).error;
  EXPECT_EQ(full.code, ErrorCode::kUnavailable);
  EXPECT_NE(full.text.find("enough memory"), std::string::npos);
}

TEST(ServerLimits, ReleaseBytesOfEndedStreams) {
  const RunningServer server(catalogue_of(std::make_shared<FakeSteps>("fake", heavy(4, 100'000))),
                             {.admission = {.queue_bytes = 4 * (400'000 + kOfARequest)}});
  for (int i = 0; i < 3; ++i) {
    MessageSocket socket = server.greet();
    for (std::uint64_t id = 1; id <= 3; ++id) {
      ASSERT_TRUE(socket.send(open_fake(id)));
      EXPECT_TRUE(std::holds_alternative<StreamEnd>(after_steps(socket)));
    }
  }
}

TEST(ServerLimits, CloseOnlyIdleClients) {
  testing::Count running;
  const RunningServer server(catalogue_of(std::make_shared<FakeSteps>("fake", endless(running))),
                             {.idle_time = 100ms, .connection = {.linger = 10ms}});
  MessageSocket busy = server.greet();
  ASSERT_TRUE(busy.send(open_fake(1)));
  MessageSocket idle = server.greet();
  EXPECT_EQ(receive<ErrorReply>(idle).error.code, ErrorCode::kUnavailable);
  EXPECT_TRUE(is_closed_by_server(idle));
  ASSERT_TRUE(busy.send(Ping{1}));
  (void)receive<Pong>(busy);
}

// A dataset whose size estimates run until they are stopped.
class EndlessSizes : public FakeSteps {
 public:
  EndlessSizes(const std::string& name, testing::Count& running)
      : FakeSteps(name), running_(running) {}
  [[nodiscard]] SizeEstimates sizes(std::stop_token stop, SizeAccuracy) const override {
    ++running_;
    testing::Gate().pass(stop);
    --running_;
    throw Cancelled{};
  }

 private:
  testing::Count& running_;
};

TEST(ServerLimits, LimitConcurrentEstimatesOfAConnection) {
  testing::Count running;
  const RunningServer server(catalogue_of(std::make_shared<EndlessSizes>("fake", running)),
                             {.session = {.max_queries = 2}, .connection = {.linger = 10ms}});
  MessageSocket socket = server.greet();
  for (std::uint64_t id = 1; id <= 3; ++id) {
    ASSERT_TRUE(socket.send(Estimate{.request_id = id, .dataset = "fake"}));
  }
  const ErrorReply refused = receive<ErrorReply>(socket);
  EXPECT_EQ(refused.error.code, ErrorCode::kLimitExceeded);
  EXPECT_EQ(refused.request_id, 3U);
  MessageSocket other = server.greet();
  ASSERT_TRUE(other.send(Estimate{.request_id = 4, .dataset = "fake"}));
  ASSERT_TRUE(other.send(Ping{1}));
  (void)receive<Pong>(other);
}

TEST(ServerLimits, CloseClientsThatReadTooSlowly) {
  const auto notes = std::make_shared<Notes>();
  const RunningServer server(
      catalogue_of(std::make_shared<FakeSteps>("fake", heavy(40, 1'000'000))),
      {.admission = {.observer = notes},
       .connection = {.write_timeout = 50ms, .linger = 10ms, .send_buffer_bytes = 64 * 1024}});
  MessageSocket stalled = server.greet();
  ASSERT_TRUE(stalled.send(open_fake(1)));
  EXPECT_TRUE(eventually([&] { return notes->has("stream left"); }))
      << "It reads nothing, and its stream goes on.";
}

// Steps with `triangles` triangles and an estimate of `estimated` at error 1.
class SizedSteps : public FakeSteps {
 public:
  SizedSteps(const std::string& name, std::size_t triangles, double estimated)
      : FakeSteps(name, heavy(triangles, 10)), estimated_(estimated) {}
  [[nodiscard]] SizeEstimates sizes(std::stop_token, SizeAccuracy) const override {
    const auto size_at = [estimated = estimated_](const IsosurfaceRequest& request) {
      const double floor = std::max(request.error, request.thresholds.error_floor);
      return SurfaceSize{
          .triangles = estimated / floor, .bytes = estimated, .extracted = estimated};
    };
    return {.of = [=](const StepRequest& step) { return size_at(step.request); }, .rough = size_at};
  }

 private:
  double estimated_;
};

// 1000 triangles at error 1; suggestions aim at nine tenths of the limit. 2.83 is the first level
// of the error schedule at which 400 fit.
TEST(ServerLimits, RejectLargeFinalStepsWithAnErrorThatFits) {
  for (const double estimated : {1000.0, 420.0}) {  // Rejected before and after the step is made.
    const RunningServer server(
        catalogue_of(std::make_shared<SizedSteps>("fake", /*triangles=*/1000, estimated)),
        {.service = {.limits = {.max_triangles = 400}}});
    MessageSocket socket = server.greet();
    ASSERT_TRUE(socket.send(open_fake(1)));
    const ErrorReply refused = receive<ErrorReply>(socket);
    EXPECT_EQ(refused.error.code, ErrorCode::kLimitExceeded);
    EXPECT_EQ(refused.request_id, 1U);
    EXPECT_NE(refused.error.text.find("1000 triangles"), std::string::npos) << refused.error.text;
    EXPECT_NE(refused.error.text.find("at most 400; it fits with an error of 2.8284271247461903 "
                                      "voxels, or"),
              std::string::npos)
        << refused.error.text;
    ASSERT_TRUE(socket.send(Ping{1}));
    (void)receive<Pong>(socket);
  }
}

TEST(ServerLimits, AcceptFinalStepsWithinTheTriangleLimit) {
  const RunningServer server(catalogue_of(std::make_shared<SizedSteps>("fake", 400, 470)),
                             {.service = {.limits = {.max_triangles = 400}}});
  MessageSocket socket = server.greet();
  ASSERT_TRUE(socket.send(open_fake(1)));
  EXPECT_TRUE(std::holds_alternative<StreamEnd>(after_steps(socket)));
}

TEST(ServerLimits, LimitTheFirstMessageFurther) {
  const RunningServer server(fake_catalogue(), {.connection = {.max_hello_bytes = 100}});
  MessageSocket socket = server.connect();
  ASSERT_TRUE(socket.send(Hello{.token = std::string(200, 'x')}));
  EXPECT_EQ(receive<ErrorReply>(socket).error.code, ErrorCode::kMessageTooLarge);
  EXPECT_TRUE(is_closed_by_server(socket));
}

// ---- draining

TEST(Draining, CompletesRunningStreamsAndRejectsNewOnes) {
  testing::Gate may_end;
  testing::Gate has_begun;
  RunningServer server(catalogue_of(
      std::make_shared<FakeSteps>("fake", [&](const StepRequest& step, const std::stop_token&) {
        has_begun.open();
        may_end.pass();
        return testing::octahedron_step(step);
      })));
  MessageSocket busy = server.greet();
  MessageSocket other = server.greet();
  ASSERT_TRUE(busy.send(open_fake(1)));
  ASSERT_TRUE(has_begun.pass());
  server.drain();
  ASSERT_TRUE(eventually([&] {
    if (!other.send(Estimate{.request_id = 5, .dataset = "fake"})) return true;
    auto message = other.receive();
    return message && error_of(*message).code == ErrorCode::kUnavailable;
  }));
  MessageSocket late = server.connect();
  ASSERT_TRUE(late.send(Hello{}));
  (void)receive<Welcome>(late);
  ASSERT_TRUE(late.send(open_fake(1)));
  EXPECT_EQ(receive<ErrorReply>(late).error.code, ErrorCode::kUnavailable);
  may_end.open();
  const ServerMessage end = after_steps(busy);
  ASSERT_TRUE(std::holds_alternative<StreamEnd>(end)) << error_of(end).text;
  EXPECT_EQ(std::get<StreamEnd>(end).outcome, StreamOutcome::kComplete);
  server.wait();
}

TEST(Draining, StopsIdleServersAtOnceAndSlowOnesAtTheTimeout) {
  RunningServer idle(fake_catalogue(), {.connection = {.linger = 10ms}});
  MessageSocket client = idle.greet();
  idle.drain();
  idle.wait();
  testing::Count running;
  RunningServer slow(catalogue_of(std::make_shared<FakeSteps>("fake", endless(running))),
                     {.drain_time = 50ms, .connection = {.linger = 10ms}});
  MessageSocket busy = slow.greet();
  ASSERT_TRUE(busy.send(open_fake(1)));
  ASSERT_TRUE(running.reaches(1));
  slow.drain();
  slow.wait();
  EXPECT_EQ(running, 0);
}

// The signal goes to the test's own process, so the server must handle signals before it is sent.
TEST(Draining, StopsAtOnceAfterASecondSignal) {
  testing::Count running;
  RunningServer server(catalogue_of(std::make_shared<FakeSteps>("fake", endless(running))),
                       {.handles_signals = true, .drain_time = 1h, .connection = {.linger = 10ms}});
  MessageSocket busy = server.greet();
  ASSERT_TRUE(busy.send(open_fake(1)));
  ASSERT_TRUE(running.reaches(1));
  ASSERT_EQ(::kill(::getpid(), SIGTERM), 0);
  MessageSocket late = server.greet();
  ASSERT_TRUE(eventually([&] {
    if (!late.send(Estimate{.request_id = 5, .dataset = "fake"})) return true;
    const auto answer = late.receive();
    return answer && error_of(*answer).code == ErrorCode::kUnavailable;
  })) << "The first signal begins to drain.";
  EXPECT_EQ(running, 1) << "and what runs goes on.";
  ASSERT_EQ(::kill(::getpid(), SIGTERM), 0);
  server.wait();
  EXPECT_EQ(running, 0);
}

// ---- events

TEST(ServerObserver, ReportsAStreamOnceWithItsFacts) {
  const auto notes = std::make_shared<Notes>();
  const RunningServer server(catalogue_of(std::make_shared<FakeSteps>("fake", heavy(3, 1000))),
                             {.admission = {.observer = notes}});
  {
    MessageSocket socket = server.greet();
    ASSERT_TRUE(socket.send(open_fake(5)));
    EXPECT_TRUE(std::holds_alternative<StreamEnd>(after_steps(socket)));
    ASSERT_TRUE(eventually([&] { return notes->has("stream complete"); }));
  }
  const RequestFacts facts = notes->last();
  EXPECT_EQ(facts.request, 5U);
  EXPECT_EQ(facts.dataset, "fake");
  EXPECT_EQ(facts.steps, 1U);
  EXPECT_EQ(facts.tiles, 3U);
  EXPECT_EQ(facts.bytes, 3000U);
  ASSERT_TRUE(facts.seconds_to_first_tile && facts.seconds_to_last_tile);
  EXPECT_LE(*facts.seconds_to_first_tile, *facts.seconds_to_last_tile);
  EXPECT_LE(*facts.seconds_to_last_tile, facts.seconds);
  EXPECT_STREQ(notes->client().protocol, "tcp");
  EXPECT_FALSE(notes->has("stream left"));
}

TEST(ServerObserver, ReportsAbandonedStreams) {
  const auto notes = std::make_shared<Notes>();
  testing::Count running;
  const RunningServer server(catalogue_of(std::make_shared<FakeSteps>("fake", endless(running))),
                             {.admission = {.observer = notes}});
  {
    MessageSocket socket = server.greet();
    ASSERT_TRUE(socket.send(open_fake(1)));
    ASSERT_TRUE(running.reaches(1));
  }
  EXPECT_TRUE(eventually([&] { return notes->has("stream left"); }));
}

// ---- shares

class SharesTest : public TokensTest {
 protected:
  SharesTest() {
    write(access_line("alice", "good", {"*"}) + "\n" + access_line("eve", "greedy", {"*"}));
  }
  // Connects with that token and receives Welcome.
  static MessageSocket welcomed(const RunningServer& server, const std::string& token) {
    MessageSocket socket = greet_with(server, token);
    (void)receive<Welcome>(socket);
    return socket;
  }

  testing::Count running_;
};

TEST_F(SharesTest, LeavesWorkersToOtherClients) {
  auto catalogue = fake_catalogue("quick");
  catalogue->add(std::make_shared<FakeSteps>("slow", endless(running_)));
  ServerOptions with = options();
  with.service.workers = 3;
  const RunningServer server(catalogue, with);
  std::vector<MessageSocket> many;
  for (int i = 0; i < 20; ++i) {
    many.push_back(welcomed(server, "greedy"));
    ASSERT_TRUE(many.back().send(open_fake(1, "slow")));
  }
  ASSERT_TRUE(running_.reaches_at_least(1));
  MessageSocket alice = welcomed(server, "good");
  ASSERT_TRUE(alice.send(open_fake(1, "quick")));
  EXPECT_TRUE(std::holds_alternative<StreamEnd>(after_steps(alice)));
  EXPECT_EQ(running_, 1);
}

// Only a trusted gateway may name the clients behind it.
TEST_F(SharesTest, GivesEachClientOfAGatewayItsOwnShare) {
  for (const bool is_trusted : {true, false}) {
    testing::Count running;
    auto catalogue = fake_catalogue("quick");
    catalogue->add(std::make_shared<FakeSteps>("slow", endless(running)));
    ServerOptions with;
    with.service.workers = 4;
    if (is_trusted) with.admission.trusted_proxies = *AddressRanges::parse({"127.0.0.1"});
    const RunningServer server(catalogue, with);
    const auto asking_for = [&](const std::string& name, const std::string& dataset) {
      MessageSocket socket = server.connect();
      EXPECT_TRUE(socket.send(Hello{.on_behalf_of = name}));
      (void)receive<Welcome>(socket);
      EXPECT_TRUE(socket.send(open_fake(1, dataset)));
      return socket;
    };
    std::vector<MessageSocket> many;
    for (int i = 0; i < 10; ++i) many.push_back(asking_for("address 192.0.2.66", "slow"));
    many.push_back(asking_for("address 192.0.2.67", "slow"));
    ASSERT_TRUE(running.reaches(is_trusted ? 2 : 1));
    MessageSocket alice = asking_for("address 192.0.2.7", "quick");
    if (is_trusted) {
      EXPECT_TRUE(std::holds_alternative<StreamEnd>(after_steps(alice)));
    }
    EXPECT_EQ(running, is_trusted ? 2 : 1);
  }
}

TEST_F(SharesTest, SendsARetryDelayWithRejections) {
  ServerOptions with = options();
  with.service.workers = 1;
  with.service.limits.waiting_time = 1'200ms;
  const RunningServer server(catalogue_of(std::make_shared<FakeSteps>("fake", endless(running_))),
                             with);
  std::vector<MessageSocket> many;
  for (int i = 0; i < 3; ++i) {  // Each step not made before is expected to take half a second.
    many.push_back(welcomed(server, "greedy"));
    ASSERT_TRUE(many.back().send(open_fake(1)));
    ASSERT_TRUE(many.back().send(Ping{1}));
    (void)receive<Pong>(many.back());
  }
  MessageSocket one_more = welcomed(server, "greedy");
  ASSERT_TRUE(one_more.send(open_fake(1)));
  const Error refusal = receive<ErrorReply>(one_more).error;
  EXPECT_EQ(refusal.code, ErrorCode::kUnavailable);
  EXPECT_GE(refusal.retry_after, 1);
  EXPECT_NE(refusal.text.find("retry in"), std::string::npos) << refusal.text;
  ASSERT_TRUE(one_more.send(Estimate{.request_id = 2, .dataset = "fake"}));
  EXPECT_EQ(receive<ErrorReply>(one_more).error.code, ErrorCode::kUnavailable);
  MessageSocket alice = welcomed(server, "good");
  ASSERT_TRUE(alice.send(open_fake(1)));
  ASSERT_TRUE(alice.send(Ping{1}));
  (void)receive<Pong>(alice);  // Her stream is not rejected but waits.
}

OpenStream with_a_large_map(std::uint64_t id) {
  OpenStream open = open_fake(id);
  open.request.thresholds.regions.resize(kMaxThresholdRegions, {.threshold = 0.5});
  return open;
}

TEST_F(SharesTest, ReservesQueueBytesForWaitingRequests) {
  constexpr std::size_t kOfOne = 2 * kMaxThresholdRegions * sizeof(ThresholdRegion) + kOfARequest;
  ServerOptions with = options();
  with.service.workers = 1;
  with.admission.queue_bytes = 4 * (2 * kOfOne + kOfARequest);
  const auto notes = std::make_shared<Notes>();
  with.admission.observer = notes;
  const RunningServer server(catalogue_of(std::make_shared<FakeSteps>("fake", endless(running_))),
                             with);
  std::optional<MessageSocket> first = welcomed(server, "greedy");
  MessageSocket second = welcomed(server, "greedy");
  ASSERT_TRUE(first->send(with_a_large_map(1)));
  Estimate estimate{.request_id = 2, .dataset = "fake", .request = with_a_large_map(1).request};
  ASSERT_TRUE(first->send(estimate));
  ASSERT_TRUE(first->send(Ping{1}));
  (void)receive<Pong>(*first);
  ASSERT_TRUE(second.send(with_a_large_map(1)));
  const Error full = receive<ErrorReply>(second).error;
  EXPECT_EQ(full.code, ErrorCode::kUnavailable);
  EXPECT_GT(full.retry_after, 0);
  EXPECT_TRUE(notes->has("queue_bytes"));
  MessageSocket alice = welcomed(server, "good");
  ASSERT_TRUE(alice.send(with_a_large_map(1)));
  ASSERT_TRUE(alice.send(Ping{1}));
  (void)receive<Pong>(alice);  // A share may take a quarter of the total.
  first.reset();
  EXPECT_TRUE(eventually([&, id = std::uint64_t{1}]() mutable {
    if (!second.send(with_a_large_map(++id)) || !second.send(Ping{id})) return false;
    const auto answer = second.receive();
    return answer && std::holds_alternative<Pong>(*answer);
  })) << "What a client has left is free.";
}

TEST_F(SharesTest, ReservesQueueBytesForWaitingLists) {
  ServerOptions with = options();
  with.admission.queue_bytes = 1000;
  const RunningServer server(two_datasets(), with);
  MessageSocket socket = welcomed(server, "good");
  ASSERT_TRUE(socket.send(ListDatasets{7}));
  const ErrorReply refusal = receive<ErrorReply>(socket);
  EXPECT_EQ(refusal.error.code, ErrorCode::kUnavailable);
  EXPECT_EQ(refusal.request_id, 7U);
}

}  // namespace
}  // namespace multitetra
