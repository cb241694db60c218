#include "server/operations/request_log.hpp"

#include <chrono>
#include <thread>

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>
#include <nlohmann/json.hpp>

#include "server/operations/log.hpp"

namespace multitetra {
namespace {

const ClientFacts kAlice = {
    .protocol = "websocket", .connection = 7, .peer = "192.0.2.7:1234", .name = "alice"};

// The log lines of `work`, as JSON.
template <typename Work>
std::vector<nlohmann::json> logged(LogLevel level, const Work& work) {
  ::testing::internal::CaptureStderr();
  start_log({.format = LogFormat::kJson, .level = level});
  RequestLog log;
  work(log);
  spdlog::default_logger_raw()->flush();
  std::istringstream text(::testing::internal::GetCapturedStderr());
  start_log({.level = LogLevel::kOff});
  std::vector<nlohmann::json> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(nlohmann::json::parse(line));
  return lines;
}

TEST(RequestLog, LogsAStreamWithItsConnectionRequestAndCosts) {
  const auto lines = logged(LogLevel::kInfo, [](RequestLog& log) {
    log.request_ended(kAlice, {.kind = "stream",
                               .request = 5,
                               .dataset = "head",
                               .isovalue = 500.5,
                               .error = 1,
                               .unit = "voxel",
                               .steps = 3,
                               .tiles = 40,
                               .bytes = 1000,
                               .seconds_to_first_tile = 0.01,
                               .seconds_to_last_tile = 0.2,
                               .seconds = 0.25});
  });
  ASSERT_EQ(lines.size(), 1U);
  const auto& line = lines[0];
  EXPECT_EQ(line.at("text"), "stream");
  EXPECT_EQ(line.at("connection"), 7);
  EXPECT_EQ(line.at("request"), "5");
  EXPECT_EQ(line.at("transport"), "websocket");
  EXPECT_EQ(line.at("peer"), "192.0.2.7:1234");
  EXPECT_EQ(line.at("name"), "alice");
  EXPECT_EQ(line.at("dataset"), "head");
  EXPECT_EQ(line.at("isovalue"), 500.5);
  EXPECT_EQ(line.at("steps"), 3);
  EXPECT_EQ(line.at("tiles"), 40);
  EXPECT_EQ(line.at("first_tile_seconds"), 0.01);
  EXPECT_EQ(line.at("outcome"), "complete");
}

TEST(RequestLog, LogsTheRequestIdOfTheHttpResponse) {
  const auto lines = logged(LogLevel::kInfo, [](RequestLog& log) {
    log.request_ended(kAlice, {.kind = "isosurface", .id = "00ab", .outcome = "complete"});
    log.http_answered(kAlice, {.id = "00ac",
                               .proxy_id = "7f9c-1",
                               .kind = "datasets",
                               .method = "GET",
                               .target = "/v1/datasets?a b\n",
                               .status = 401,
                               .outcome = "unauthenticated",
                               .reason = "A token is required."});
  });
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0].at("request"), "00ab");
  EXPECT_EQ(lines[1].at("request"), "00ac");
  EXPECT_EQ(lines[1].at("proxy_request"), "7f9c-1");
  EXPECT_EQ(lines[1].at("status"), 401);
  EXPECT_EQ(lines[1].at("outcome"), "unauthenticated");
  EXPECT_EQ(lines[1].at("reason"), "A token is required.");
  EXPECT_EQ(lines[1].at("target"), "/v1/datasets?a b\n");
}

TEST(RequestLog, LogsEveryRequestAboutADataset) {
  const std::vector<const char*> kinds = {"stream", "list", "estimate", "slice", "probe"};
  const auto lines = logged(LogLevel::kInfo, [&](RequestLog& log) {
    for (const char* kind : kinds) log.request_ended(kAlice, {.kind = kind, .dataset = "head"});
    log.request_ended(kAlice, {.kind = "neuroglancer", .id = "00ab", .dataset = "head"});
    log.http_answered(kAlice, {.id = "00ab", .kind = "neuroglancer", .status = 200});
  });
  ASSERT_EQ(lines.size(), kinds.size() + 1);
  for (std::size_t i = 0; i < kinds.size(); ++i) EXPECT_EQ(lines[i].at("text"), kinds[i]);
  EXPECT_EQ(lines.back().at("request"), "00ab");
}

TEST(RequestLog, LogsAConnectionOnceItsClientIsKnown) {
  const auto probed = [](RequestLog& log) {
    log.connected({.connection = 8});
    log.disconnected({.connection = 8}, 0.1);
  };
  EXPECT_TRUE(logged(LogLevel::kInfo, probed).empty());
  EXPECT_EQ(logged(LogLevel::kDebug, probed).size(), 2U);
  const auto lines = logged(LogLevel::kInfo, [](RequestLog& log) {
    ClientFacts alice = kAlice;
    log.connected(alice);
    alice.is_welcomed = true;
    log.welcomed(alice);
    log.disconnected(alice, 2);
  });
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0].at("text"), "connected");
  EXPECT_EQ(lines[0].at("name"), "alice");
  EXPECT_EQ(lines[1].at("text"), "disconnected");
}

TEST(RequestLog, LogsSuccessfulFilesAndHealthChecksAtDebugLevel) {
  const auto work = [](RequestLog& log) {
    log.http_answered(kAlice, {.id = "1", .kind = "tile", .status = 200});
    log.http_answered(kAlice, {.id = "2", .kind = "livez", .status = 200});
    log.connected({.protocol = "http", .connection = 1});
  };
  EXPECT_TRUE(logged(LogLevel::kInfo, work).empty());
  EXPECT_EQ(logged(LogLevel::kDebug, work).size(), 3U);
}

// The same for every transport: 503 and UNAVAILABLE, 404 and UNKNOWN_DATASET.
TEST(RequestLog, WarnsAboutMissingCapacityAndFailures) {
  const auto lines = logged(LogLevel::kInfo, [](RequestLog& log) {
    log.error_answered(kAlice, {ErrorCode::kUnavailable, "No memory now.", 5}, 3);
    log.error_answered(kAlice, {ErrorCode::kInternal, "It failed."}, 4);
    log.http_answered(kAlice, {.status = 503});
    log.refused(kAlice, "connections");
    log.error_answered(kAlice, {ErrorCode::kUnauthenticated, "Unknown token."}, 0);
    log.error_answered(kAlice, {ErrorCode::kLimitExceeded, "Too many requests.", 1}, 5);
    log.http_answered(kAlice, {.status = 401});
    log.http_answered(kAlice, {.status = 429});
    log.refused(kAlice, "idle_seconds");
  });
  ASSERT_EQ(lines.size(), 9U);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    EXPECT_EQ(lines[i].at("level"), i < 4 ? "warning" : "info") << lines[i];
  }
}

TEST(RequestLog, LogsTheReasonOfRejectionsAndErrors) {
  const auto lines = logged(LogLevel::kInfo, [](RequestLog& log) {
    log.refused(kAlice, "connections");
    log.error_answered(kAlice, {ErrorCode::kUnknownDataset, "There is none."}, 3);
  });
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0].at("limit"), "connections");
  EXPECT_EQ(lines[0].at("level"), "warning");
  EXPECT_EQ(lines[1].at("text"), "error");
  EXPECT_EQ(lines[1].at("reason"), "There is none.");
  EXPECT_EQ(lines[1].at("outcome"), "unknown_dataset");
  EXPECT_EQ(lines[1].at("request"), "3");
}

TEST(RequestLog, LogsTheReasonOfAFailureWithItsDataset) {
  const auto lines = logged(LogLevel::kInfo, [](RequestLog& log) {
    log.request_ended(kAlice, {.dataset = "head",
                               .outcome = "internal",
                               .failure = Error{ErrorCode::kInternal, "The disk failed."}});
  });
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].at("level"), "warning");
  EXPECT_EQ(lines[0].at("dataset"), "head");
  EXPECT_EQ(lines[0].at("outcome"), "internal");
  EXPECT_EQ(lines[0].at("reason"), "The disk failed.");
}

TEST(RequestLog, OmitsTokensInTargets) {
  const auto target = [](const char* requested) {
    const auto lines = logged(LogLevel::kInfo, [requested](RequestLog& log) {
      log.http_answered(kAlice, {.target = requested, .status = 400});
    });
    return lines.at(0).at("target").get<std::string>();
  };
  EXPECT_EQ(target("/v1/x?isovalue=1&token=mt_00ff&error=2"), "/v1/x?isovalue=1&token=***&error=2");
  EXPECT_EQ(target("/v1/x?Access_Token=abc"), "/v1/x?Access_Token=***");
  EXPECT_EQ(target("/v1/x?q=mt_00ff"), "/v1/x?q=***");
  EXPECT_EQ(target("/v1/x?mt_00ff&a"), "/v1/x?***&a");
  EXPECT_EQ(target("/v1/x?a=%2F&b=1"), "/v1/x?a=%2F&b=1");
  for (const char* const spelled :
       {"/v1/token/abc/x", "/v1/TOKEN/abc/x", "/v1//token//abc/x", "/v1/%74oken/abc/x",
        "/v1/%2574oken/abc/x", "/v1%2Ftoken%2Fabc%2Fx", "/V1/Token/abc", "/x?a=1;token=abc"}) {
    EXPECT_EQ(target(spelled).find("abc"), std::string::npos) << target(spelled);
  }
  EXPECT_EQ(target("/?"), "/?");
}

TEST(RequestLog, OmitsTokensInReasons) {
  const auto lines = logged(LogLevel::kInfo, [](RequestLog& log) {
    log.http_answered(kAlice, {.target = "/",
                               .status = 404,
                               .reason = "There is no \"/v1/token/abc/x\" here, nor mt_00ff."});
  });
  EXPECT_EQ(lines.at(0).at("reason"), "There is no \"/v1/token/***/x\" here, nor ***");
}

TEST(RequestLog, LogsAnHttpRejectionOnceWithItsReason) {
  const ClientFacts alice{.protocol = "http", .connection = 7, .name = "alice"};
  const auto lines = logged(LogLevel::kInfo, [&](RequestLog& log) {
    log.refused(alice, "requests_per_second");
    log.refused(alice, "connections");
    log.error_answered(alice, {ErrorCode::kUnknownDataset, "There is none."}, 0);
    log.request_ended(alice, {.kind = "isosurface", .id = "1", .outcome = "unknown_dataset"});
    log.http_answered(alice, {.id = "1", .kind = "isosurface", .status = 404, .reason = "None."});
  });
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].at("name"), "alice");
  EXPECT_EQ(lines[0].at("status"), 404);
  EXPECT_EQ(lines[0].at("reason"), "None.");
}

// A flood from one client neither fills the disk nor displaces lines about others.
TEST(RequestLog, SamplesFloodsAndCountsOmittedLines) {
  const ClientFacts flooding{.peer = "192.0.2.66:1"};
  const auto lines = logged(LogLevel::kInfo, [&](RequestLog& log) {
    for (int i = 0; i < 10'000; ++i) {
      log.http_answered(flooding, {.kind = "datasets", .target = "/", .status = 429});
      log.refused(flooding, "connections");
      log.error_answered(flooding, {ErrorCode::kLimitExceeded, "Too many."}, 1);
    }
    log.refused(kAlice, "connections");
    std::this_thread::sleep_for(std::chrono::milliseconds(150));
    log.refused(flooding, "connections");
  });
  EXPECT_LE(lines.size(), 200U);
  EXPECT_EQ(lines.at(lines.size() - 2).at("limit"), "connections");
  EXPECT_GT(lines.back().at("left_out"), 29'000);
}
}  // namespace
}  // namespace multitetra
