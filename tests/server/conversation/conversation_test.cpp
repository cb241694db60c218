// A conversation without a network: the test takes the place of the transport.
#include "server/conversation/session_runner.hpp"
#include "server/operations/log.hpp"

#include <fstream>
#include <future>

#include <gtest/gtest.h>
#include <boost/asio/use_future.hpp>

#include "server/dataset/byte_source.hpp"
#include "server/service/local_service.hpp"
#include "tests/support/fake_steps.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

using testing::catalogue_of;
using testing::FakeSteps;

// A conversation after the handshake; the only worker stays busy until it is freed.
class ConversationTest : public ::testing::Test {
 protected:
  ConversationTest() {
    set_log_level(LogLevel::kOff);
    service_.workers().post({.share = "another", .number = service_.workers().new_client()},
                            {.run = [freed = freed_.get_future().share()] { freed.wait(); }});
    receive(Hello{});
    EXPECT_TRUE(std::holds_alternative<Welcome>(next()));
  }
  ~ConversationTest() override {
    free_the_worker();
    session_->on_disconnect();
    io_.restart();
    io_.run();
    service_.workers().join();
  }

  void receive(const ClientMessage& message) { session_->receive(serialize(message)); }
  void open(std::uint64_t id) {
    receive(OpenStream{.request_id = id,
                       .dataset = "fake",
                       .steps = StepPolicy::kFinalOnly,
                       .cached_tile_digests = {}});
  }
  ServerMessage next() {
    auto message = asio::co_spawn(
        io_, [this] { return session_->next_message(); }, asio::use_future);
    io_.restart();
    while (message.wait_for(std::chrono::seconds(0)) != std::future_status::ready) io_.run_one();
    return message.get().value();
  }
  // Returns whether the conversation accepts another message now.
  bool has_room() {
    if (!room_.valid()) {
      room_ = asio::co_spawn(
          io_, [this] { return session_->until_readable(); }, asio::use_future);
    }
    io_.restart();
    io_.poll();
    if (room_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return false;
    room_.get();
    return true;
  }
  void free_the_worker() {
    if (!std::exchange(is_free_, true)) freed_.set_value();
  }

  std::shared_ptr<FakeSteps> source_ = std::make_shared<FakeSteps>("fake");
  // A rate so low that even a slow machine exceeds it.
  AdmissionControl admission_{{.requests = {.per_second = 5, .burst = 300}}};
  asio::io_context io_{1};
  LocalService service_{io_.get_executor(), catalogue_of(source_), {.workers = 1}};
  std::promise<void> freed_;
  bool is_free_ = false;
  std::future<void> room_;
  ConnectionContextPtr client_ = admission_.admit("tcp", "127.0.0.1", "test").client;
  std::shared_ptr<SessionRunner> session_ = std::make_shared<SessionRunner>(
      io_.get_executor(), service_.open(client_), Session(catalogue_of(source_), {}), client_);
};

// Every stream that is kept, here or in the workers' queue, shares ownership of the source, as does
// the forecast of its time.
TEST_F(ConversationTest, KeepsAtMostTwoStreamsWhenManySupersede) {
  const long before = source_.use_count();
  constexpr std::uint64_t kStreams = 100;
  for (std::uint64_t id = 1; id <= kStreams; ++id) {
    open(id);
    EXPECT_LE(source_.use_count(), before + 3);
  }
  for (std::uint64_t id = 1; id < kStreams; ++id) {
    EXPECT_EQ(std::get<StreamEnd>(next()).outcome, StreamOutcome::kSuperseded);
  }
  free_the_worker();
  EXPECT_EQ(std::get<StepBegin>(next()).request_id, kStreams);
}

TEST_F(ConversationTest, StopsReadingWhileADatasetListWaits) {
  EXPECT_TRUE(has_room());
  receive(Ping{1});
  EXPECT_TRUE(has_room());
  receive(ListDatasets{2});
  EXPECT_FALSE(has_room());
  EXPECT_TRUE(std::holds_alternative<Pong>(next()));
  EXPECT_FALSE(has_room());
  EXPECT_TRUE(std::holds_alternative<DatasetList>(next()));
  EXPECT_TRUE(has_room());
}

TEST_F(ConversationTest, PausesReadingFromClientsAboveTheRate) {
  OpenStream open{.request_id = 1,
                  .dataset = "fake",
                  .steps = StepPolicy::kFinalOnly,
                  .cached_tile_digests = {}};
  for (std::uint64_t i = 0; i < kMaxHeldDigests; ++i) open.cached_tile_digests.push_back({i, i});
  receive(open);
  std::optional<ServerMessage> reply;
  do {
    EXPECT_TRUE(has_room());
    ++open.request_id;
    receive(open);
    reply = next();
  } while (std::holds_alternative<StreamEnd>(*reply) && open.request_id < 1000);
  const auto* refusal = std::get_if<ErrorReply>(&*reply);
  ASSERT_NE(refusal, nullptr);
  EXPECT_EQ(refusal->error.code, ErrorCode::kLimitExceeded);
  EXPECT_FALSE(has_room());
  session_->enforce_limits(std::chrono::steady_clock::now() + std::chrono::seconds(6));
  EXPECT_TRUE(has_room());
}

class LoggedErrors : public ServiceObserver {
 public:
  void error_answered(const ClientFacts&, const Error& error, std::uint64_t) override {
    texts.push_back(error.text);
  }
  void request_ended(const ClientFacts&, const RequestFacts& facts) override {
    if (facts.failure) failures.push_back(facts.dataset + ": " + facts.failure->text);
  }
  std::vector<std::string> texts;
  std::vector<std::string> failures;
};

TEST(ConversationLog, NamesHiddenAndDamagedDatasets) {
  const auto logged = std::make_shared<LoggedErrors>();
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "tokens") << "guests none public-*\n";
  AdmissionControl admission{{.tokens = folder.path() / "tokens", .observer = logged}};
  asio::io_context io{1};
  const auto catalogue = std::make_shared<DatasetCatalogue>();
  catalogue->add(std::make_shared<FakeSteps>("fake"));
  catalogue->add(std::make_shared<FakeSteps>(
      "public-damaged", [](const StepRequest&, const std::stop_token&) -> EncodedStep {
        throw DatasetFileError("Brick 7 is damaged.");
      }));
  LocalService service{io.get_executor(), catalogue, {.workers = 1}};
  const ConnectionContextPtr client = admission.admit("tcp", "127.0.0.1", "test").client;
  const auto conversation = std::make_shared<SessionRunner>(
      io.get_executor(), service.open(client), Session(catalogue, {}, admission.access()), client);
  const auto answer_to = [&](const ClientMessage& message) {
    conversation->receive(serialize(message));
    auto reply = asio::co_spawn(
        io, [&] { return conversation->next_message(); }, asio::use_future);
    io.restart();
    io.run();
    return reply.get().value();
  };
  EXPECT_TRUE(std::holds_alternative<Welcome>(answer_to(Hello{})));
  const auto hidden = answer_to(OpenStream{.request_id = 1, .dataset = "fake"});
  const auto missing = answer_to(OpenStream{.request_id = 2, .dataset = "fakes"});
  EXPECT_TRUE(std::get<ErrorReply>(hidden).error.text.starts_with("No dataset is named \"fake\";"));
  EXPECT_TRUE(std::get<ErrorReply>(missing).error.text.starts_with("No dataset is named"));
  ASSERT_EQ(logged->texts.size(), 2u);
  EXPECT_EQ(logged->texts[0], "Dataset \"fake\" is not allowed for this token.");
  EXPECT_TRUE(logged->texts[1].starts_with("No dataset is named"));
  const auto damaged = answer_to(OpenStream{.request_id = 3, .dataset = "public-damaged"});
  EXPECT_EQ(std::get<ErrorReply>(damaged).error.code, ErrorCode::kDamagedData);
  ASSERT_EQ(logged->failures.size(), 1u) << "with its dataset";
  EXPECT_TRUE(logged->failures[0].starts_with("public-damaged: ")) << logged->failures[0];
  EXPECT_EQ(logged->texts.size(), 2u) << "and not twice";
  conversation->on_disconnect();
  service.workers().join();
}

}  // namespace
}  // namespace multitetra
