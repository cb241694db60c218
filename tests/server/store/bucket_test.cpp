// An S3 bucket: listing and multipart uploads, with signed requests.
#include "server/store/bucket.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "server/store/store_error.hpp"
#include "tests/support/served_bucket.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

const HttpStoreOptions kQuick = {.max_attempts = 2,
                                 .first_pause = std::chrono::milliseconds(1),
                                 .longest_pause = std::chrono::milliseconds(5)};

class BucketTest : public ::testing::Test {
 protected:
  // Returns a file of more than two parts.
  [[nodiscard]] fs::path large_file() const {
    std::string text((std::size_t{33} << 20) + 5, 'a');
    for (std::size_t i = 0; i < text.size(); i += 1001) text[i] = static_cast<char>(i >> 10);
    folder_.file("large", text);
    return folder_.path() / "large";
  }
  template <typename Action>
  static std::string failure(const Action& action) {
    try {
      action();
    } catch (const StoreError& error) {
      return error.what();
    }
    return "none";
  }
  // The number of files in the bucket, including remains of uploads.
  [[nodiscard]] std::size_t files_in_bucket() const {
    std::size_t files = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder_.path())) {
      files += entry.is_regular_file() ? 1U : 0U;
    }
    return files;
  }

  const ServedBucket bucket_;
  const TemporaryFolder& folder_ = bucket_.folder();
};

TEST_F(BucketTest, ListsOnlyObjectsDirectlyBelowTheFolder) {
  for (const char* const name :
       {"b.mtd", "a & b.mtd", "c.txt", "in/d.mtd", "in/e.mtd", "in/f/g.mtd"}) {
    fs::create_directories((folder_.path() / name).parent_path());
    folder_.file(name, "x");
  }
  using Names = std::vector<std::string>;
  EXPECT_EQ(list_bucket("s3://volumes", ".mtd", kQuick),
            (Names{"s3://volumes/a & b.mtd", "s3://volumes/b.mtd"}));
  for (const char* const place : {"s3://volumes/in", "s3://volumes/in/"}) {
    EXPECT_EQ(list_bucket(place, ".mtd", kQuick),
              (Names{"s3://volumes/in/d.mtd", "s3://volumes/in/e.mtd"}));
  }
  EXPECT_EQ(list_bucket("s3://volumes/none/", ".mtd", kQuick), Names{});
}

TEST_F(BucketTest, FollowsContinuationTokens) {
  for (int i = 0; i < 25; ++i) folder_.file("x" + std::to_string(100 + i) + ".mtd", "x");
  EXPECT_EQ(list_bucket("s3://volumes/", ".mtd", kQuick).size(), 25U);
}

TEST_F(BucketTest, RejectsListingsThatNeverEnd) {
  const struct {
    const char* place;
    ListingLimits limits;
    const char* problem;
  } listings[] = {{"s3://volumes/endless/", {.pages = 12}, "more than 12 pages"},
                  {"s3://volumes/endless/", {.name_bytes = 200}, "more than 200 bytes of names"},
                  {"s3://volumes/repeats/", {}, "a repeated continuation token"},
                  {"s3://volumes/long-token/", {}, "a continuation token of 5000 bytes"}};
  for (const auto& [place, limits, problem] : listings) {
    const std::string found = failure([&] { (void)list_bucket(place, ".mtd", kQuick, limits); });
    EXPECT_NE(found.find(problem), std::string::npos) << found;
  }
}

TEST_F(BucketTest, LimitsTheListedPages) {
  for (int i = 0; i < 25; ++i) folder_.file("x" + std::to_string(100 + i) + ".mtd", "x");
  EXPECT_EQ(list_bucket("s3://volumes/", ".mtd", kQuick, {.pages = 3}).size(), 25U);
  EXPECT_NE(failure([] {
              (void)list_bucket("s3://volumes/", ".mtd", kQuick, {.pages = 2});
            }).find("more than 2 pages"),
            std::string::npos);
}

TEST_F(BucketTest, ReportsWhyListingFails) {
  setenv("AWS_SECRET_ACCESS_KEY", "another secret", 1);
  EXPECT_NE(failure([] { (void)list_bucket("s3://volumes/", ".mtd", kQuick); }).find("status 403"),
            std::string::npos);
}

TEST_F(BucketTest, DistinguishesForbiddenFromMissingObjects) {
  folder_.file("old.mtd", "old content");
  setenv("AWS_SECRET_ACCESS_KEY", "another secret", 1);
  EXPECT_NE(
      failure([] { (void)find_object("s3://volumes/old.mtd", 3, kQuick); }).find("status 403"),
      std::string::npos);
}

TEST_F(BucketTest, UploadsAFileInPartsAsOneObject) {
  setenv("AWS_SESSION_TOKEN", "of+temporary/credentials=", 1);
  const fs::path file = large_file();
  std::vector<double> fractions;
  const std::string name = "new (1)=a+b.mtd";
  upload_file(file, "s3://volumes/" + name, {}, kQuick,
              [&](double fraction) { fractions.push_back(fraction); });
  EXPECT_TRUE(bytes_of_file(folder_.path() / name) == bytes_of_file(file));
  EXPECT_EQ(fractions.size(), 3U);
  EXPECT_EQ(fractions.back(), 1);
  EXPECT_EQ(files_in_bucket(), 2U) << "No part is left.";
}

TEST_F(BucketTest, ReplacesOnlyTheExpectedVersion) {
  folder_.file("source", "new");
  folder_.file("old.mtd", "old content");
  const fs::path file = folder_.path() / "source";
  const auto found = find_object("s3://volumes/old.mtd", 3, kQuick);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->begin.size(), 3U);
  EXPECT_FALSE(find_object("s3://volumes/none.mtd", 3, kQuick));
  using Kind = UploadCondition::Kind;
  EXPECT_NE(failure([&] {
              upload_file(file, "s3://volumes/old.mtd", {}, kQuick);
            }).find("another file was written to this address"),
            std::string::npos);
  const UploadCondition same{.kind = Kind::kSameVersion, .etag = found->etag};
  upload_file(file, "s3://volumes/old.mtd", same, kQuick);
  EXPECT_EQ(bytes_of_file(folder_.path() / "old.mtd"), "new");
  EXPECT_NE(failure([&] {
              upload_file(file, "s3://volumes/old.mtd", same, kQuick);
            }).find("another file was written to this address"),
            std::string::npos);
  upload_file(file, "s3://volumes/old.mtd", {.kind = Kind::kAny}, kQuick);
  EXPECT_EQ(files_in_bucket(), 2U) << "Nothing is left of those that failed.";
}

TEST_F(BucketTest, AbortsAnUploadThatFails) {
  const fs::path file = large_file();
  EXPECT_NE(failure([&] {
              upload_file(file, "s3://volumes/fails-part2.mtd", {}, kQuick);
            }).find("status 500"),
            std::string::npos);
  EXPECT_NE(failure([&] {
              upload_file(file, "s3://volumes/fails-complete.mtd", {}, kQuick);
            }).find("InternalError"),
            std::string::npos);
  EXPECT_EQ(files_in_bucket(), 1U);
}

TEST_F(BucketTest, DownloadsAndRemovesObjects) {
  const fs::path file = large_file();
  folder_.file("empty", "");
  const TemporaryFolder into;
  for (const char* const name : {"large", "empty"}) {
    EXPECT_TRUE(download_file(std::string("s3://volumes/") + name, into.path() / name, kQuick));
    EXPECT_TRUE(bytes_of_file(into.path() / name) == bytes_of_file(folder_.path() / name)) << name;
  }
  EXPECT_FALSE(download_file("s3://volumes/none", into.path() / "none", kQuick));
  EXPECT_EQ(entries_of(into.path()), 2U);
  upload_file(into.path() / "empty", "s3://volumes/new", {}, kQuick);
  EXPECT_EQ(bytes_of_file(folder_.path() / "new"), "");
  remove_object("s3://volumes/large", kQuick);
  remove_object("s3://volumes/none", kQuick);
  EXPECT_FALSE(fs::exists(file));
  EXPECT_EQ(files_in_bucket(), 2U);
}

TEST(BucketFolders, StripTheSuffix) {
  EXPECT_TRUE(is_bucket_folder("s3://volumes", ".mtd"));
  EXPECT_TRUE(is_bucket_folder("s3://volumes/in/", ".mtd"));
  EXPECT_FALSE(is_bucket_folder("s3://volumes/head.mtd", ".mtd"));
  EXPECT_FALSE(is_bucket_folder("https://host/folder/", ".mtd"));
}

}  // namespace
}  // namespace multitetra
