// Caches that sessions share: tiles, steps, and running computations.
#include <future>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include "common/base/lru_map.hpp"
#include "server/service/detail/single_flight.hpp"
#include "server/service/surface_cache.hpp"
#include "tests/support/octahedra.hpp"
#include "tests/support/waiting.hpp"

namespace multitetra {
namespace {

using testing::coarse_tiles;
using testing::Count;
using testing::eventually;
using testing::fine_tiles;
using testing::Gate;

// ---- LruMap

TEST(LruMap, EvictsTheLeastRecentlyUsed) {
  LruMap<int, std::string> map(3);
  map.add(1, "one", 1);
  map.add(2, "two", 1);
  map.add(3, "three", 1);
  EXPECT_NE(map.find(1), nullptr);
  map.add(4, "four", 1);
  EXPECT_EQ(map.find(2), nullptr);
  ASSERT_NE(map.find(1), nullptr);
  EXPECT_EQ(*map.find(1), "one");
  EXPECT_NE(map.find(3), nullptr);
  EXPECT_NE(map.find(4), nullptr);
}

TEST(LruMap, NeverExceedsItsCapacity) {
  std::mt19937 random(3);
  LruMap<std::uint64_t, int> map(100);
  for (int i = 0; i < 10000; ++i) {
    map.add(random() % 50, i, random() % 120);
    ASSERT_LE(map.weight(), map.capacity());
    (void)map.find(random() % 50);
  }
  EXPECT_GT(map.size(), 0U);
}

TEST(LruMap, RemovesTheKeysOfARange) {
  LruMap<int, int> map(100);
  for (int i = 0; i < 10; ++i) map.add(i, i, 2);
  map.remove_between(3, 7);
  EXPECT_EQ(map.size(), 6U);
  EXPECT_EQ(map.weight(), 12U);
  EXPECT_NE(map.find(2), nullptr);
  EXPECT_EQ(map.find(3), nullptr);
  EXPECT_EQ(map.find(6), nullptr);
  EXPECT_NE(map.find(7), nullptr);
}

TEST(LruMap, CountsAReplacedEntryOnce) {
  LruMap<int, int> map(10);
  for (int i = 0; i < 5; ++i) map.add(7, i, 6);
  EXPECT_EQ(map.weight(), 6U);
  EXPECT_EQ(*map.find(7), 4);
  map.add(7, 9, 11);
  EXPECT_EQ(map.find(7), nullptr) << "the old value is not the new one";
}

// ---- SingleFlight

class SingleFlightTest : public ::testing::Test {
 protected:
  // A computation that ends when the test signals it, or when stopped.
  int compute(const std::stop_token& stop) {
    ++started_;
    if (may_end_.pass(stop)) return 42;
    ++stopped_;
    throw Cancelled{};
  }
  std::future<int> request(std::stop_token stop = {}) {
    return std::async(std::launch::async, [this, stop] {
      return flights_.get("key", stop, [this](const std::stop_token& all) { return compute(all); });
    });
  }
  // Returns whether `callers` callers wait for the same result.
  [[nodiscard]] bool are_waiting(std::size_t callers) {
    return eventually([&] { return flights_.callers("key") == callers; });
  }

  SingleFlight<std::string, int> flights_;
  Count started_;
  Count stopped_;
  Gate may_end_;
};

TEST_F(SingleFlightTest, ComputesOnceForConcurrentCallers) {
  std::vector<std::future<int>> callers;
  for (int i = 0; i < 6; ++i) callers.push_back(request());
  ASSERT_TRUE(are_waiting(6));
  may_end_.open();
  for (auto& caller : callers) EXPECT_EQ(caller.get(), 42);
  EXPECT_EQ(started_, 1);
  EXPECT_EQ(request().get(), 42);
  EXPECT_EQ(started_, 2) << "it keeps nothing";
}

TEST_F(SingleFlightTest, ContinuesWithoutTheComputingCaller) {
  std::stop_source first_stop;
  auto first = request(first_stop.get_token());
  ASSERT_TRUE(started_.reaches(1));
  auto second = request();
  ASSERT_TRUE(are_waiting(2));
  first_stop.request_stop();
  EXPECT_EQ(flights_.callers("key"), 1U);
  may_end_.open();
  EXPECT_EQ(second.get(), 42);
  EXPECT_EQ(first.get(), 42);
  EXPECT_EQ(started_, 1);
}

TEST_F(SingleFlightTest, ReturnsAtOnceToAStoppedCaller) {
  auto first = request();
  ASSERT_TRUE(started_.reaches(1));
  std::stop_source stop;
  auto second = request(stop.get_token());
  ASSERT_TRUE(are_waiting(2));
  stop.request_stop();
  EXPECT_THROW(second.get(), Cancelled);
  EXPECT_EQ(stopped_, 0);
  may_end_.open();
  EXPECT_EQ(first.get(), 42);
}

TEST_F(SingleFlightTest, StopsWithoutCallersAndRestartsForTheNext) {
  std::stop_source stop;
  auto first = request(stop.get_token());
  auto second = request(stop.get_token());
  ASSERT_TRUE(are_waiting(2));
  stop.request_stop();
  EXPECT_THROW(first.get(), Cancelled);
  EXPECT_THROW(second.get(), Cancelled);
  EXPECT_EQ(stopped_, 1);
  may_end_.open();
  EXPECT_EQ(request().get(), 42);
}

TEST_F(SingleFlightTest, ReportsAFailureToAllCallersWithoutCachingIt) {
  const auto fail = [&](const std::stop_token&) -> int {
    may_end_.pass();
    throw std::runtime_error("no");
  };
  auto first = std::async(std::launch::async, [&] { return flights_.get("key", {}, fail); });
  ASSERT_TRUE(are_waiting(1));
  auto second = request();
  ASSERT_TRUE(are_waiting(2));
  may_end_.open();
  EXPECT_THROW(first.get(), std::runtime_error);
  EXPECT_THROW(second.get(), std::runtime_error);
  EXPECT_EQ(request().get(), 42);
}

// Simulates copying a large result when memory is short.
struct Uncopyable {
  Uncopyable() = default;
  Uncopyable(const Uncopyable&) { throw std::bad_alloc(); }
  Uncopyable(Uncopyable&&) noexcept = default;
  Uncopyable& operator=(Uncopyable&&) noexcept = default;
};

TEST(SingleFlight, SurvivesAThrowingCopy) {
  SingleFlight<std::string, Uncopyable> flights;
  Gate may_end;
  const auto request = [&] {
    (void)flights.get("key", {}, [&](const std::stop_token&) {
      may_end.pass();
      return Uncopyable();
    });
  };
  auto first = std::async(std::launch::async, request);
  auto second = std::async(std::launch::async, request);
  ASSERT_TRUE(eventually([&] { return flights.callers("key") == 2; }));
  may_end.open();
  EXPECT_THROW(first.get(), std::bad_alloc);
  EXPECT_THROW(second.get(), std::bad_alloc);
  EXPECT_THROW(request(), std::bad_alloc) << "it is computed anew";
}

// ---- SurfaceCache

EncodedStep step_of(std::vector<EncodedTile> tiles) {
  return {.tetrahedra = 100, .active_tetrahedra = 10, .tiles = std::move(tiles)};
}

TEST(SurfaceCache, ReturnsACachedStep) {
  SurfaceCache cache(1 << 20);
  int made = 0;
  const auto make = [&made](const std::stop_token&) {
    ++made;
    return step_of(fine_tiles());
  };
  const EncodedStep first = cache.get("a", {}, make);
  const EncodedStep again = cache.get("a", {}, make);
  EXPECT_EQ(made, 1);
  EXPECT_EQ(again.tetrahedra, 100U);
  EXPECT_EQ(again.active_tetrahedra, 10U);
  ASSERT_EQ(again.tiles.size(), first.tiles.size());
  for (std::size_t i = 0; i < first.tiles.size(); ++i) {
    EXPECT_EQ(again.tiles[i].summary, first.tiles[i].summary);
    EXPECT_EQ(again.tiles[i].payload, first.tiles[i].payload) << "the same bytes in memory";
  }
  (void)cache.get("b", {}, make);
  EXPECT_EQ(made, 2);
}

TEST(SurfaceCache, StoresASharedTileOnce) {
  SurfaceCache cache(1 << 20);
  (void)cache.get("coarse", {}, [](const std::stop_token&) { return step_of(coarse_tiles()); });
  const std::size_t before = cache.tiles().counts().tiles;
  (void)cache.get("fine", {}, [](const std::stop_token&) { return step_of(fine_tiles()); });
  EXPECT_EQ(cache.tiles().counts().tiles, before + 1) << "of two tiles one is in both";
}

// Simplifications of two models may give the same triangles with different distances to the models.
TEST(SurfaceCache, KeepsTheSummaryOfEachStepForASharedTile) {
  SurfaceCache cache(1 << 20);
  const auto simplified_to = [](double bound) {
    return [bound](const std::stop_token&) {
      EncodedStep step = step_of(fine_tiles());
      for (EncodedTile& tile : step.tiles) tile.summary.simplification_bound = bound;
      return step;
    };
  };
  (void)cache.get("a", {}, simplified_to(0.1));
  (void)cache.get("b", {}, simplified_to(0.3));
  const auto never = [](const std::stop_token&) -> EncodedStep { throw std::logic_error("made"); };
  for (const EncodedTile& tile : cache.get("a", {}, never).tiles) {
    EXPECT_EQ(tile.summary.simplification_bound, 0.1);
  }
  for (const EncodedTile& tile : cache.get("b", {}, never).tiles) {
    EXPECT_EQ(tile.summary.simplification_bound, 0.3);
  }
}

TEST(SurfaceCache, CachesNothingWithZeroBytes) {
  SurfaceCache cache(0);
  int made = 0;
  for (int i = 0; i < 3; ++i) {
    (void)cache.get("a", {}, [&made](const std::stop_token&) {
      ++made;
      return step_of(fine_tiles());
    });
  }
  EXPECT_EQ(made, 3);
  EXPECT_EQ(cache.tiles().counts().bytes, 0U);
}

TEST(SurfaceCache, StaysWithinItsBytesAndCorrect) {
  SurfaceCache cache(5000);
  std::mt19937 random(5);
  for (int i = 0; i < 300; ++i) {
    const bool is_fine = random() % 2 == 0;
    const std::string key = (is_fine ? "fine " : "coarse ") + std::to_string(random() % 20);
    const EncodedStep step = cache.get(key, {}, [is_fine](const std::stop_token&) {
      return step_of(is_fine ? fine_tiles() : coarse_tiles());
    });
    ASSERT_EQ(step.tiles[0].summary, (is_fine ? fine_tiles() : coarse_tiles())[0].summary);
    ASSERT_LE(cache.tiles().counts().bytes, 5000U);
  }
}

}  // namespace
}  // namespace multitetra
