// An HTTP store that is slow, unreachable or lies gives correct answers or errors.
#include "server/store/http_store.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
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
    return {.max_attempts = 3, .first_pause = milliseconds(1), .longest_pause = milliseconds(5)};
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
  static std::string failure(const Action& action) {
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

TEST_F(HttpStoreTest, ReadsWholeObjectsAndRangesAndReportsMissingOnes) {
  const auto good = store("/");
  EXPECT_EQ(whole(*good), text_);
  EXPECT_EQ(part(*good), text_.substr(100, 50));
  EXPECT_EQ(as_text(good->get_range("a/object", ObjectStore::kFromEnd, 7)),
            text_.substr(text_.size() - 7));
  EXPECT_EQ(as_text(good->get_range("a/object", text_.size() - 3, 50)),
            text_.substr(text_.size() - 3));
  EXPECT_FALSE(good->get("a/other", 10));
  EXPECT_NE(failure([&] { return good->get("a/object", 10); }).find("the limit of 10 bytes"),
            std::string::npos);
}

TEST_F(HttpStoreTest, RetriesTransientErrors) {
  for (const char* const lie : {"503", "truncated", "lost"}) {
    const auto twice = store(std::string("/lies/") + lie + "/2");
    EXPECT_EQ(whole(*twice), text_) << lie;
  }
  const auto twice = store("/lies/wrong-range/2");
  EXPECT_EQ(part(*twice), text_.substr(100, 50));
}

TEST_F(HttpStoreTest, ReportsFailedRequests) {
  const auto error_after = [&](const std::string& lie) {
    const auto never = store("/lies/" + lie + "/1000");
    return failure([&] { return part(*never); });
  };
  EXPECT_NE(error_after("503").find("status 503"), std::string::npos);
  EXPECT_NE(error_after("wrong-range").find("requested bytes 100-149"), std::string::npos);
  EXPECT_NE(error_after("truncated"), "none");
  EXPECT_NE(error_after("lost"), "none");
  EXPECT_NE(failure([&] { return part(*store("/whole/")); }).find("does not serve ranges"),
            std::string::npos);
}

TEST_F(HttpStoreTest, LimitsTheWaitForAStalledStore) {
  HttpStoreOptions options = quick();
  options.deadline = milliseconds(400);
  const auto stalled = store("/lies/stalled/1000", options);
  const auto begin = steady_clock::now();
  EXPECT_NE(failure([&] { return whole(*stalled); }), "none");
  EXPECT_LT(steady_clock::now() - begin, std::chrono::seconds(10));
}

TEST_F(HttpStoreTest, GivesUpOnAStoreThatStallsTwice) {
  HttpStoreOptions options = quick();
  options.max_attempts = 100;
  options.stall_timeout = std::chrono::seconds(1);
  std::atomic<int> tried_again = 0;
  options.on_retry = [&] { ++tried_again; };
  const auto stalled = store("/lies/stalled/1000", options);
  EXPECT_NE(failure([&] { return whole(*stalled); }).find("Timeout"), std::string::npos);
  EXPECT_EQ(tried_again, 1);
}

TEST_F(HttpStoreTest, GivesUpOnAStoreThatSendsAFewBytesASecond) {
  HttpStoreOptions options = quick();
  options.max_attempts = 1;
  options.stall_timeout = std::chrono::seconds(1);
  const auto slow = store("/lies/trickle/1000", options);
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_NE(failure([&] { return whole(*slow); }).find("Timeout"), std::string::npos);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
}

TEST_F(HttpStoreTest, RejectsRequestsDuringTheCooldown) {
  HttpStoreOptions options = quick();
  options.cooldown_after_failure = std::chrono::hours(1);
  const auto failing = store("/lies/503/3", options);
  EXPECT_NE(failure([&] { return whole(*failing); }).find("status 503"), std::string::npos);
  // The store would answer now, but gets no request.
  EXPECT_NE(failure([&] { return whole(*failing); }).find("failed recently"), std::string::npos);
}

TEST_F(HttpStoreTest, SharesItsConnectionsAmongMoreThreads) {
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

TEST_F(HttpStoreTest, DistinguishesRejectionFromAMissingObject) {
  for (const char* const status : {"401", "403"}) {
    const auto refusing = store(std::string("/lies/") + status + "/1000");
    EXPECT_THROW((void)refusing->get("a/object", 10), StoreAccessDenied) << status;
    EXPECT_THROW((void)refusing->get_range("a/none", 0, 10), StoreAccessDenied) << status;
  }
}

TEST_F(HttpStoreTest, FollowsRedirectsToOtherHostsOnlyIfAllowed) {
  EXPECT_EQ(whole(*store("/moved/")), text_);
  const std::string port = server_.address().substr(server_.address().rfind(':'));
  const std::string elsewhere = "/redirect/localhost" + port + "/";
  EXPECT_NE(failure([&] { return whole(*store(elsewhere)); }).find("--follow"), std::string::npos);
  HttpStoreOptions options = quick();
  options.allow_other_hosts = true;
  EXPECT_EQ(whole(*store(elsewhere, options)), text_);
}

TEST_F(HttpStoreTest, RejectsKeysOutsideTheAddress) {
  EXPECT_NE(failure([&] { return store("/b/")->get("../a/object", 10'000); }).find("--follow"),
            std::string::npos);
  EXPECT_FALSE(store("/b/")->get("%2e%2e/a/object", 10'000));
  EXPECT_FALSE(store("/a/")->get("object?part", 10'000));
  HttpStoreOptions options = quick();
  options.allow_other_hosts = true;
  EXPECT_EQ(as_text(store("/b/", options)->get("../a/object", 10'000)), text_);
}

TEST_F(HttpStoreTest, SendsCredentialsOnlyToTheirHost) {
  const std::string host = server_.address().substr(7);
  const std::string port = host.substr(host.rfind(':'));
  HttpStoreOptions options = quick();
  options.allow_other_hosts = true;
  const auto with_user = [&](const std::string& below) {
    return http_store("http://reader:a%20secret@" + host + below, options);
  };
  EXPECT_EQ(whole(*with_user("/private/")), text_);
  EXPECT_EQ(whole(*with_user("/moved/private/")), text_);
  const auto seen_by = [&](ObjectStore& store) { return as_text(store.get("x", 10'000)); };
  EXPECT_NE(seen_by(*with_user("/headers/")).find("Authorization"), std::string::npos);
  const std::string elsewhere = "/redirect/localhost" + port + "/headers/";
  EXPECT_EQ(seen_by(*with_user(elsewhere)).find("Authorization"), std::string::npos);

  setenv("AWS_ENDPOINT_URL",
         (server_.address() + "/redirect/localhost" + port + "/headers").c_str(), 1);
  setenv("AWS_ACCESS_KEY_ID", "reader", 1);
  setenv("AWS_SECRET_ACCESS_KEY", "a secret", 1);
  setenv("AWS_SESSION_TOKEN", "a token", 1);
  const std::string seen = seen_by(*http_store("s3://volumes", options));
  for (const char* name :
       {"AWS_ENDPOINT_URL", "AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY", "AWS_SESSION_TOKEN"}) {
    unsetenv(name);
  }
  EXPECT_NE(seen.find("Host: localhost"), std::string::npos);
  EXPECT_EQ(seen.find("a token"), std::string::npos);
  EXPECT_EQ(seen.find("Authorization"), std::string::npos);
}

TEST_F(HttpStoreTest, OmitsPasswordsFromErrors) {
  const std::string host = server_.address().substr(7);
  const auto refusing = http_store("http://reader:wrong@" + host + "/private/", quick());
  const std::string text = failure([&] { return whole(*refusing); });
  EXPECT_NE(text.find("status 401"), std::string::npos) << text;
  EXPECT_EQ(text.find("wrong"), std::string::npos) << text;
  EXPECT_EQ(refusing->place("x").string().find("wrong"), std::string::npos);
}

TEST(Addresses, RejectsBucketsWithoutAName) {
  EXPECT_THROW((void)http_store("s3:///path"), StoreError);
  EXPECT_TRUE(is_address("s3://bucket"));
  EXPECT_FALSE(is_address("head.mtd"));
}

}  // namespace
}  // namespace multitetra
