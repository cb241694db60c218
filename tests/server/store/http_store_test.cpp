// A store behind HTTP that is late, lost, or lies: answers are right or there is none.
#include "server/store/http_store.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/folder_server.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

class HttpStoreTest : public ::testing::Test {
 protected:
  HttpStoreTest() : server_(folder_.path()) {
    for (int i = 0; i < 1000; ++i) text_ += std::to_string(i) + " ";
    folder_.file("a/object", text_);
  }
  [[nodiscard]] std::unique_ptr<ObjectStore> store(const std::string& below,
                                                   HttpStoreOptions options = quick()) const {
    return http_store(server_.address() + below, options);
  }
  static HttpStoreOptions quick() {
    return {.tries = 3, .first_pause = milliseconds(1), .longest_pause = milliseconds(5)};
  }
  [[nodiscard]] std::string whole(ObjectStore& store) const {
    return as_text(store.get("a/object", text_.size()));
  }
  [[nodiscard]] std::string part(ObjectStore& store) const {
    return as_text(store.get_range("a/object", 100, 50));
  }
  static std::string as_text(const std::optional<std::vector<std::byte>>& bytes) {
    if (!bytes) return "none";
    return {reinterpret_cast<const char*>(bytes->data()), bytes->size()};
  }
  template <typename Action>
  static std::string trouble(const Action& action) {
    try {
      (void)action();
    } catch (const StoreError& error) {
      return error.what();
    }
    return "none";
  }

  const TemporaryFolder folder_;
  std::string text_;
  const FolderServer server_;
};

TEST_F(HttpStoreTest, GivesWholesAndPartsAndKnowsWhatIsMissing) {
  const auto good = store("/");
  EXPECT_EQ(whole(*good), text_);
  EXPECT_EQ(part(*good), text_.substr(100, 50));
  EXPECT_EQ(as_text(good->get_range("a/object", ObjectStore::kFromEnd, 7)),
            text_.substr(text_.size() - 7));
  EXPECT_EQ(as_text(good->get_range("a/object", text_.size() - 3, 50)),
            text_.substr(text_.size() - 3));
  EXPECT_FALSE(good->get("a/other", 10));
  EXPECT_NE(trouble([&] { return good->get("a/object", 10); }).find("more than the 10 bytes"),
            std::string::npos);
}

TEST_F(HttpStoreTest, TriesAgainWhatMayPass) {
  for (const char* const lie : {"503", "truncated", "lost"}) {
    const auto twice = store(std::string("/lies/") + lie + "/2");
    EXPECT_EQ(whole(*twice), text_) << lie;
  }
  const auto twice = store("/lies/wrong-range/2");
  EXPECT_EQ(part(*twice), text_.substr(100, 50));
}

TEST_F(HttpStoreTest, TellsWhatDoesNotPass) {
  const auto told = [&](const std::string& lie) {
    const auto never = store("/lies/" + lie + "/1000");
    return trouble([&] { return part(*never); });
  };
  EXPECT_NE(told("503").find("status 503"), std::string::npos);
  EXPECT_NE(told("wrong-range").find("asked for bytes 100-149"), std::string::npos);
  EXPECT_NE(told("truncated"), "none");
  EXPECT_NE(told("lost"), "none");
  EXPECT_NE(trouble([&] { return part(*store("/whole/")); }).find("does not serve ranges"),
            std::string::npos);
}

TEST_F(HttpStoreTest, WaitsForAStoreThatStallsNoLongerThanItsDeadline) {
  HttpStoreOptions options = quick();
  options.deadline = milliseconds(400);
  const auto stalled = store("/lies/stalled/1000", options);
  const auto begin = steady_clock::now();
  EXPECT_NE(trouble([&] { return whole(*stalled); }), "none");
  EXPECT_LT(steady_clock::now() - begin, std::chrono::seconds(10));
}

TEST_F(HttpStoreTest, LetsAStoreThatFailedRest) {
  HttpStoreOptions options = quick();
  options.rest_after_failure = std::chrono::hours(1);
  const auto failing = store("/lies/503/3", options);
  EXPECT_NE(trouble([&] { return whole(*failing); }).find("status 503"), std::string::npos);
  // It would answer now; nobody asks.
  EXPECT_NE(trouble([&] { return whole(*failing); }).find("failed a moment ago"),
            std::string::npos);
}

TEST_F(HttpStoreTest, HasAsManyConnectionsAsAllowedAndServesMoreThreads) {
  HttpStoreOptions options = quick();
  options.connections = 2;
  const auto narrow = store("/", options);
  std::atomic<int> right = 0;
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 6; ++i) {
      threads.emplace_back([&] {
        for (int k = 0; k < 10; ++k) right += whole(*narrow) == text_ ? 1 : 0;
      });
    }
  }
  EXPECT_EQ(right, 60);
}

TEST(Addresses, OfBucketsWithoutANameAreRefused) {
  EXPECT_THROW((void)http_store("s3:///path"), StoreError);
  EXPECT_TRUE(is_address("s3://bucket"));
  EXPECT_FALSE(is_address("head.mtd"));
}

}  // namespace
}  // namespace multitetra
