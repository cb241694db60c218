// The load generator: its scripts are repeatable, and its clients detect faults.
#include <gtest/gtest.h>

#include "client/library/message_socket.hpp"
#include "client/load/agreement.hpp"
#include "client/load/load_run.hpp"
#include "tests/client/cutting_proxy.hpp"
#include "tests/client/transport_listener.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/running_server.hpp"
#include "tests/support/served_datasets.hpp"

namespace multitetra {
namespace {

using std::chrono::milliseconds;
using testing::Cut;
using testing::CuttingProxy;
using testing::RunningServer;

DatasetInfo some_dataset() {
  DatasetInfo info;
  info.name = "head";
  info.dims = {64, 48, 32};
  info.min = -100;
  info.max = 100;
  info.suggested_isovalues = {10, 40};
  return info;
}

std::vector<ScriptedRequest> scripted_requests(ScriptKind kind, std::uint64_t seed, int count) {
  Script script(kind, {some_dataset()}, seed, {});
  std::vector<ScriptedRequest> all;
  for (int i = 0; i < count; ++i) all.push_back(script.next());
  return all;
}

std::string bytes_of(const ScriptedRequest& scripted) {
  OpenStream open = scripted.open;
  open.request_id = 1;
  return serialize(open) + std::to_string(scripted.pause.count());
}

constexpr std::array kScripts = {ScriptKind::kRandomIsovalues, ScriptKind::kDrag,
                                 ScriptKind::kRegion, ScriptKind::kMixed};

// Only steps with the same finest spacing and simplification are compared.
TEST(Agreement, ComparesOnlyIdenticalSteps) {
  Agreement agreement;
  const StepBegin final_step = {.is_final = true, .request = {.simplify = true}};
  StepBegin unsimplified = final_step;
  unsimplified.is_final = false;
  unsimplified.is_unsimplified = true;
  StepBegin coarse = unsimplified;
  coarse.finest_spacing = 2;
  using enum Agreement::Verdict;
  EXPECT_EQ(agreement.compare("head", final_step, {1, 1}), kNew);
  EXPECT_EQ(agreement.compare("head", unsimplified, {1, 2}), kNew);
  EXPECT_EQ(agreement.compare("head", coarse, {1, 3}), kNew);
  EXPECT_EQ(agreement.compare("skin", coarse, {1, 4}), kNew);
  EXPECT_EQ(agreement.compare("head", final_step, {1, 1}), kSame);
  EXPECT_EQ(agreement.compare("head", unsimplified, {1, 2}), kSame);
  EXPECT_EQ(agreement.compare("head", unsimplified, {1, 1}), kDifferent);
}

TEST(LoadScript, RepeatsWithTheSameSeed) {
  for (const ScriptKind kind : kScripts) {
    const auto one = scripted_requests(kind, 7, 50);
    const auto repeated = scripted_requests(kind, 7, 50);
    const auto other = scripted_requests(kind, 8, 50);
    int same = 0;
    for (std::size_t i = 0; i < one.size(); ++i) {
      EXPECT_EQ(bytes_of(one[i]), bytes_of(repeated[i]));
      same += bytes_of(one[i]) == bytes_of(other[i]) ? 1 : 0;
    }
    EXPECT_LT(same, 25) << name(kind);
  }
}

TEST(LoadScript, MakesOnlyValidRequests) {
  for (const ScriptKind kind : kScripts) {
    for (const ScriptedRequest& scripted : scripted_requests(kind, 3, 100)) {
      EXPECT_TRUE(validated(scripted.open.request)) << name(kind);
      EXPECT_GT(scripted.open.request.isovalue, -100);
      EXPECT_LT(scripted.open.request.isovalue, 100);
    }
  }
}

TEST(LoadScript, CompletesTheSurfaceAtTheEndOfADrag) {
  const auto drag = scripted_requests(ScriptKind::kDrag, 5, 40);
  for (std::size_t i = 0; i < drag.size(); ++i) {
    EXPECT_EQ(drag[i].replaced_after.has_value(), i % 20 != 19) << i;
  }
}

TEST(LoadTimes, ComputesQuantiles) {
  Times times;
  EXPECT_EQ(times.quantile(0.5), 0);
  for (const int i : {5, 3, 1, 4, 2}) times.add(i);
  EXPECT_EQ(times.quantile(0.5), 3);
  EXPECT_EQ(times.quantile(0.8), 4);
  EXPECT_EQ(times.quantile(0.81), 5);
  EXPECT_EQ(times.quantile(1), 5);
  EXPECT_EQ(times.mean(), 3);
}

// ---- with a server

CataloguePtr gyroid() {
  static const DatasetPtr dataset = make_dataset(testing::fields::gyroid(40, 0.4, 7), "gyroid");
  return testing::catalogue_with({dataset}, std::make_shared<SurfaceCache>(64 << 20));
}

// The replies to one request, with the verdicts of validator and assembler.
class StreamChecksTest : public ::testing::Test {
 protected:
  void SetUp() override {
    MessageSocket socket = server_.greet();
    ASSERT_TRUE(socket.send(ListDatasets{.request_id = 1}));
    info_ = testing::receive<DatasetList>(socket).datasets.front();
    ASSERT_TRUE(socket.send(open_));
    do {
      messages_.push_back(*socket.receive());
    } while (!std::holds_alternative<StreamEnd>(messages_.back()));
    ASSERT_GE(tiles().size(), 4U);
  }

  [[nodiscard]] std::vector<std::size_t> tiles() const {
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < messages_.size(); ++i) {
      if (std::holds_alternative<Tile>(messages_[i])) places.push_back(i);
    }
    return places;
  }
  [[nodiscard]] bool passes(const std::vector<ServerMessage>& messages) const {
    StreamChecks checks = StreamChecks::cheap(info_, open_, /*tiles_per_decoded=*/1);
    for (const ServerMessage& message : messages) {
      const auto progress = checks.receive(message);
      if (!progress) return false;
      if (const auto* end = std::get_if<StreamEnd>(&*progress)) {
        return end->outcome == StreamOutcome::kComplete;
      }
    }
    return false;
  }
  template <typename M>
  static M& last(std::vector<ServerMessage>& messages) {
    for (auto message = messages.rbegin(); message != messages.rend(); ++message) {
      if (auto* found = std::get_if<M>(&*message)) return *found;
    }
    throw std::logic_error("no such message");
  }

  RunningServer server_{gyroid()};
  OpenStream open_{.request_id = 1,
                   .dataset = "gyroid",
                   .request = {.isovalue = 0.1, .error = 0.25},
                   .cached_tile_digests = {}};
  DatasetInfo info_;
  std::vector<ServerMessage> messages_;
};

TEST_F(StreamChecksTest, AcceptsTheOriginalStream) { EXPECT_TRUE(passes(messages_)); }

TEST_F(StreamChecksTest, RejectsAMissingMessage) {
  for (std::size_t i = 0; i < messages_.size(); ++i) {
    auto lacking = messages_;
    lacking.erase(lacking.begin() + static_cast<std::ptrdiff_t>(i));
    EXPECT_FALSE(passes(lacking)) << i;
  }
}

TEST_F(StreamChecksTest, RejectsARepeatedMessage) {
  for (std::size_t i = 0; i + 1 < messages_.size(); ++i) {
    auto doubled = messages_;
    doubled.insert(doubled.begin() + static_cast<std::ptrdiff_t>(i), messages_[i]);
    EXPECT_FALSE(passes(doubled)) << i;
  }
}

TEST_F(StreamChecksTest, RejectsADamagedTile) {
  for (const std::size_t i : tiles()) {
    auto damaged = messages_;
    auto& tile = std::get<Tile>(damaged[i]);
    std::string payload = *tile.payload;
    payload[payload.size() / 2] = static_cast<char>(payload[payload.size() / 2] ^ 0x55);
    tile.payload = std::make_shared<const std::string>(payload);
    EXPECT_FALSE(passes(damaged)) << i;
  }
}

TEST_F(StreamChecksTest, RejectsWrongSums) {
  for (int i = 0; i < 5; ++i) {
    auto wrong = messages_;
    auto& step = last<StepEnd>(wrong);
    if (i == 0) step.digest.low ^= 1;
    if (i == 1) ++step.tiles_sent;
    if (i == 2) ++step.payload_bytes;
    if (i == 3) ++last<StreamEnd>(wrong).steps;
    if (i == 4) last<StepBegin>(wrong).is_final = false;
    EXPECT_FALSE(passes(wrong)) << i;
  }
}

// ---- whole runs

LoadOptions short_load(const Endpoint& server, std::size_t clients) {
  LoadOptions options{.session = {.server = server,
                                  .script = ScriptKind::kMixed,
                                  .script_options = {.isovalues = 1,
                                                     .errors = {0.5},
                                                     .mean_pause = milliseconds(5),
                                                     .drag_interval = milliseconds(5),
                                                     .drag_length = 4}},
                      .clients = clients,
                      .threads = 2,
                      .duration = milliseconds(1000),
                      .ramp = milliseconds(50)};
  return options;
}

class LoadRun : public ::testing::TestWithParam<Transport> {};

TEST_P(LoadRun, ReportsNoFailedChecksForAGoodServer) {
  const RunningServer server(gyroid());
  std::optional<testing::TransportListener> listener;
  Endpoint endpoint = server.endpoint();
  if (GetParam() != Transport::kTcp) {
    listener.emplace(GetParam(), endpoint);
    endpoint = listener->endpoint();
  }
  for (const std::uint32_t streams_per_thorough : {1U, 4U}) {
    LoadOptions options = short_load(endpoint, 12);
    options.session.streams_per_thorough = streams_per_thorough;
    if (listener) options.session.tls = *client_tls(listener->trust());
    const LoadStatistics statistics = run_load(options);
    EXPECT_EQ(statistics.checks_failed, 0U) << statistics.failed_checks.front();
    EXPECT_EQ(statistics.tiles_sent_twice, 0U);
    EXPECT_EQ(statistics.failed, 0U);
    EXPECT_EQ(statistics.unfinished, 0U);
    EXPECT_EQ(statistics.lost_connections, 0U);
    EXPECT_EQ(statistics.connections, 12U);
    EXPECT_EQ(statistics.complete + statistics.replaced, statistics.streams);
    EXPECT_GE(statistics.complete, 2U);
    EXPECT_GT(statistics.thorough_streams, 0U);
    EXPECT_GT(statistics.tiles_decoded, 0U);
    // Includes streams that end after the scheduled time.
    EXPECT_GE(statistics.seconds, statistics.last_tile.quantile(1));
    EXPECT_GT(statistics.steps_compared, 0U);
    EXPECT_EQ(statistics.whole.count(), statistics.complete);
    EXPECT_TRUE(statistics.errors.empty()) << statistics.errors.begin()->second.example;
  }
}

INSTANTIATE_TEST_SUITE_P(, LoadRun,
                         ::testing::Values(Transport::kTcp, Transport::kSecureWebSocket));

TEST(LoadTool, ResumesACutConnectionWithoutRepeatedTiles) {
  const RunningServer server(gyroid());
  const CuttingProxy proxy({server.endpoint()},
                           [](int i) { return Cut{.tiles = 1 + static_cast<std::size_t>(i % 3)}; });
  LoadOptions options = short_load(proxy.endpoint(), 1);
  options.session.script = ScriptKind::kRandomIsovalues;
  options.session.streams_per_thorough = 2;
  const LoadStatistics statistics = run_load(options);
  EXPECT_GE(statistics.lost_connections, 1U);
  EXPECT_GE(statistics.complete, 1U);
  EXPECT_EQ(statistics.complete, statistics.streams);
  EXPECT_EQ(statistics.tiles_sent_twice, 0U);
  EXPECT_EQ(statistics.checks_failed, 0U) << statistics.failed_checks.front();
}

// All clients connect and get a first surface; then they exceed the request rate.
TEST(LoadTool, RetriesRejectedClientsAfterTheDelay) {
  const RunningServer server(gyroid(),
                             {.admission = {.requests = {.per_second = 10, .burst = 28}}});
  LoadOptions options = short_load(server.endpoint(), 12);
  options.session.script = ScriptKind::kRandomIsovalues;
  options.session.script_options.mean_pause = milliseconds(200);
  options.duration = milliseconds(1500);
  options.ramp = milliseconds(0);
  const LoadStatistics statistics = run_load(options);
  EXPECT_GT(statistics.retried_after_delay, 0U);
  EXPECT_EQ(statistics.complete, statistics.streams);
  EXPECT_EQ(statistics.clients_without_connection, 0U);
  EXPECT_EQ(statistics.checks_failed, 0U) << statistics.failed_checks.front();
  EXPECT_EQ(statistics.lost_connections, 0U);
}

TEST(LoadTool, KeepsIdleClientsConnected) {
  const RunningServer server(gyroid());
  LoadOptions options = short_load(server.endpoint(), 2);
  options.idle = 30;
  const LoadStatistics statistics = run_load(options);
  EXPECT_EQ(statistics.connections, 32U);
  EXPECT_EQ(statistics.lost_connections, 0U);
  EXPECT_EQ(statistics.clients_without_connection, 0U);
  EXPECT_GE(statistics.complete, 1U);
  options.clients = 1;
  options.session.dataset = "nothing";
  EXPECT_EQ(run_load(options).clients_without_connection, 31U);
}

TEST(SourceAddresses, EnumerateANetwork) {
  const auto network = SourceAddresses::from("127.0.1.7/29");
  ASSERT_TRUE(network);
  EXPECT_EQ(network->count(), 6U);
  EXPECT_EQ(network->of(0), "127.0.1.1");
  EXPECT_EQ(network->of(5), "127.0.1.6");
  EXPECT_EQ(network->of(6), "127.0.1.1");
  EXPECT_EQ(SourceAddresses::from("127.0.1.0/24")->count(), 254U);
  EXPECT_EQ(SourceAddresses::from("10.1.2.3")->of(4), "10.1.2.3");
  EXPECT_EQ(SourceAddresses().of(3), "");
  for (const char* wrong :
       {"", "localhost", "127.0.1.0/", "127.0.1.0/33", "127.0.1.0/4", "::1/64"}) {
    EXPECT_FALSE(SourceAddresses::from(wrong)) << wrong;
  }
}

TEST(LoadTool, GivesEachAddressItsOwnShare) {
  const RunningServer server(gyroid(), {.admission = {.connections = {.total = 9, .per_name = 1}}});
  LoadOptions options = short_load(server.endpoint(), 6);
  EXPECT_EQ(run_load(options).clients_without_connection, 5U);
  options.from = SourceAddresses::from("127.0.1.0/29").value();
  EXPECT_EQ(run_load(options).clients_without_connection, 0U);
}

TEST(LoadTool, FailsWithoutAServer) {
  LoadOptions options = short_load({.host = "127.0.0.1", .port = 1}, 3);
  const LoadStatistics statistics = run_load(options);
  EXPECT_EQ(statistics.clients_without_connection, 3U);
  EXPECT_GT(statistics.errors.at("unavailable").count, 0U);
}

TEST(LoadTool, ServesUsersAfterMisbehavingClients) {
  const RunningServer server(gyroid());
  for (const auto kind : {Misbehaviour::kStalled, Misbehaviour::kSlow, Misbehaviour::kLeaving,
                          Misbehaviour::kGarbage}) {
    LoadOptions options = short_load(server.endpoint(), 6);
    const MisbehaviourCounts counts = run_misbehaviour(kind, options);
    EXPECT_GE(counts.connections, 6U) << name(kind);
    // Users of this script wait for each surface, however slow the machine is.
    options.session.script = ScriptKind::kRandomIsovalues;
    EXPECT_GE(run_load(options).complete, 1U) << "after " << name(kind);
  }
}

}  // namespace
}  // namespace multitetra
