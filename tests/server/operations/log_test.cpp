#include "server/operations/log.hpp"

#include <sys/resource.h>

#include <chrono>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>
#include <nlohmann/json.hpp>

#include "server/operations/detail/log_sampling.hpp"
#include "server/operations/heap_trimmer.hpp"

namespace multitetra {
namespace {

// Returns what `work` writes to standard error.
template <typename Work>
std::string logged(const LogOptions& options, const Work& work) {
  ::testing::internal::CaptureStderr();
  start_log(options);
  work();
  spdlog::default_logger_raw()->flush();
  std::string text = ::testing::internal::GetCapturedStderr();
  start_log({.level = LogLevel::kOff});
  return text;
}

constexpr std::string_view kHostile = "a\nb\x1f\"\\\x01\xff\x7f{}";

TEST(Log, WritesTextLinesWithFields) {
  const std::string text = logged({}, [] {
    log_line(LogLevel::kInfo, "stream ended",
             {{"connection", std::uint64_t{7}},
              {"dataset", "my head"},
              {"isovalue", 60.5},
              {"error", std::nullopt},
              {"unit", "voxel"}});
  });
  EXPECT_TRUE(text.ends_with(
      " info stream ended connection=7 dataset=\"my head\" isovalue=60.5 unit=voxel\n"))
      << text;
}

TEST(Log, WritesJsonObjectsWithFields) {
  const std::string text = logged({.format = LogFormat::kJson}, [] {
    log_line(LogLevel::kWarning, "stream ended",
             {{"connection", std::uint64_t{7}},
              {"dataset", "my head"},
              {"isovalue", 60.5},
              {"error", std::nullopt},
              {"nan", std::numeric_limits<double>::quiet_NaN()}});
  });
  const auto line = nlohmann::json::parse(text);
  EXPECT_EQ(line.at("text"), "stream ended");
  EXPECT_EQ(line.at("level"), "warning");
  EXPECT_EQ(line.at("connection"), 7);
  EXPECT_EQ(line.at("dataset"), "my head");
  EXPECT_EQ(line.at("isovalue"), 60.5);
  EXPECT_TRUE(line.at("nan").is_null());
  EXPECT_FALSE(line.contains("error"));
  EXPECT_EQ(line.at("time").get<std::string>().size(), 27U);
}

TEST(Log, EscapesForeignBytes) {
  for (const LogFormat format : {LogFormat::kText, LogFormat::kJson}) {
    const std::string text = logged({.format = format}, [] {
      log_line(LogLevel::kInfo, kHostile, {{"agent", kHostile}});
      spdlog::info("{}", kHostile);
    });
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2) << text;
    EXPECT_EQ(text.find('\x1f'), std::string::npos);
    if (format == LogFormat::kText) continue;
    const auto end = text.find('\n');
    const auto first = nlohmann::json::parse(text.substr(0, end));
    EXPECT_EQ(first.at("text"), first.at("agent"));
    EXPECT_TRUE(nlohmann::json::parse(text.substr(end)).is_object());
  }
}

TEST(Log, OmitsLinesBelowTheLevel) {
  const std::string text = logged({.level = LogLevel::kWarning}, [] {
    EXPECT_FALSE(is_logged(LogLevel::kInfo));
    EXPECT_TRUE(is_logged(LogLevel::kWarning));
    log_line(LogLevel::kInfo, "quiet", {});
    log_line(LogLevel::kError, "loud", {});
  });
  EXPECT_EQ(text.find("quiet"), std::string::npos);
  EXPECT_NE(text.find("error loud\n"), std::string::npos);
}

TEST(Log, ParsesNamesOfFormatsAndLevels) {
  EXPECT_EQ(log_format_from("json"), LogFormat::kJson);
  EXPECT_EQ(log_format_from("xml"), std::nullopt);
  EXPECT_EQ(log_level_from("debug"), LogLevel::kDebug);
  EXPECT_EQ(log_level_from("loud"), std::nullopt);
}

// ---- sampling

TEST(LogSampler, LimitsLinesPerNameAndInTotal) {
  LogSampler lines(
      {.of_a_name = {.per_second = 1, .burst = 2}, .of_all = {.per_second = 1, .burst = 5}});
  EXPECT_EQ(lines.admit("a", 0), 0U);
  EXPECT_EQ(lines.admit("a", 0), 0U);
  EXPECT_EQ(lines.admit("a", 0), std::nullopt);
  EXPECT_EQ(lines.admit("a", 0), std::nullopt);
  EXPECT_EQ(lines.admit("b", 0), 0U);
  EXPECT_EQ(lines.admit("a", 1.5), 2U) << "which were not written";
  EXPECT_EQ(lines.admit("b", 1.5), 0U);
  std::size_t written = 0;
  for (int i = 0; i < 100; ++i) {
    if (lines.admit(std::to_string(i), 1.5)) ++written;
  }
  EXPECT_EQ(written, 1U) << "of all together five, and one more after a second";
}

// ---- memory

// Sanitizers use their own heap.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(TrimHeap, KeepsSomeMebibytesForReuse) {
  configure_allocator();
  const auto page_faults = [] {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_minflt;
  };
  const auto fill_four_pieces = [] {
    std::vector<std::vector<char>> pieces;
    for (int i = 0; i < 4; ++i) pieces.emplace_back(std::size_t{8} << 20, 'x');
  };
  fill_four_pieces();
  const long before = page_faults();
  for (int i = 0; i < 20; ++i) fill_four_pieces();
  EXPECT_LT(page_faults() - before, 20'000) << "of 164 000 pages";
}
#endif

TEST(HeapTrimmer, RunsOnceAfterWork) {
  using namespace std::chrono_literals;
  HeapTrimmer memory;
  const HeapTrimmer::Clock::time_point start{1000s};
  EXPECT_FALSE(memory.is_due(start, 0, false)) << "Nothing was done.";
  EXPECT_TRUE(memory.is_due(start + 1s, 1, true)) << "The first time for long.";
  EXPECT_FALSE(memory.is_due(start + 2s, 2, true));
  EXPECT_FALSE(memory.is_due(start + 3s, 2, false));
  EXPECT_TRUE(memory.is_due(start + 4500ms, 2, false));
  EXPECT_FALSE(memory.is_due(start + 10s, 2, false)) << "Nothing was done since.";
}

TEST(HeapTrimmer, RunsPeriodicallyDuringWork) {
  using namespace std::chrono_literals;
  HeapTrimmer memory;
  int times = 0;
  for (int second = 0; second < 300; ++second) {
    const auto now = HeapTrimmer::Clock::time_point{1000s + std::chrono::seconds(second)};
    times += memory.is_due(now, static_cast<std::uint64_t>(second) + 1, true) ? 1 : 0;
  }
  EXPECT_EQ(times, 10);
}

}  // namespace
}  // namespace multitetra
