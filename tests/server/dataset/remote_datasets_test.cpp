// A dataset over HTTP gives the surfaces of the file, or an error that names the reason.
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "common/mesh/content_digest.hpp"
#include "server/core/planning/refinement_plan.hpp"
#include "server/dataset/verify_dataset.hpp"
#include "server/extraction/detail/prefetch_bricks.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "tests/support/folder_server.hpp"
#include "tests/support/prepared_fields.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/volume_in_memory.hpp"

namespace multitetra {
namespace {

namespace fields = testing::fields;

class RemoteDatasets : public ::testing::Test {
 protected:
  RemoteDatasets() : server_(folder_.path()) {
    prepare_noise(2);
    expected_ = digests(open_dataset(folder_.path() / "noise.mtd"));
  }

  void prepare_noise(unsigned seed) const {
    prepare(*source_of(fields::integer_noise({140, 70, 70}, 90, seed)), {.name = "noise"},
            folder_.path() / "noise.mtd", {});
  }
  static std::vector<ContentDigest> digests(const DatasetPtr& dataset) {
    std::vector<ContentDigest> found;
    const SurfaceExtractor extractor(dataset);
    for (const int spacing : {8, 1}) {
      StepRequest step{.request = {.isovalue = 40.5}, .finest_spacing = spacing};
      for (const TileMesh& tile : extractor.extract(step, {}).tiles) {
        found.push_back(digest(tile.mesh));
      }
    }
    return found;
  }
  [[nodiscard]] static std::shared_ptr<RemoteFiles> files(
      const std::filesystem::path& folder = {}) {
    return std::make_shared<RemoteFiles>(
        RemoteFilesOptions{.memory_bytes = 3 << 20,
                           .folder = folder,
                           .http = {.max_attempts = 3,
                                    .first_pause = std::chrono::milliseconds(1),
                                    .longest_pause = std::chrono::milliseconds(5),
                                    .deadline = std::chrono::milliseconds(5000)}});
  }
  [[nodiscard]] std::string address(const std::string& lie = "") const {
    return server_.address() + lie + "/noise.mtd";
  }
  // The error message of making surfaces, or "none".
  [[nodiscard]] std::string failure(const DatasetPtr& dataset) const {
    try {
      (void)digests(dataset);
    } catch (const StoreError& error) {
      return error.what();
    } catch (const DatasetFileError& error) {
      return error.what();
    }
    return "none";
  }

  const TemporaryFolder folder_;
  const FolderServer server_;
  std::vector<ContentDigest> expected_;
};

TEST_F(RemoteDatasets, ReturnTheSurfacesOfTheFile) {
  ASSERT_FALSE(expected_.empty());
  const DatasetPtr near = open_dataset(folder_.path() / "noise.mtd");
  const DatasetPtr far = open_dataset(address(), files());
  EXPECT_EQ(far->info, near->info);
  EXPECT_EQ(digests(far), expected_);
  EXPECT_EQ(verify_dataset(address()), std::filesystem::file_size(folder_.path() / "noise.mtd"));
}

TEST_F(RemoteDatasets, ReadFromBucketsWithSignedRequests) {
  setenv("AWS_ENDPOINT_URL", (server_.address() + "/s3").c_str(), 1);
  EXPECT_THROW((void)open_dataset("s3://volumes/noise.mtd", files()), StoreError);  // Unsigned.
  setenv("AWS_ACCESS_KEY_ID", "reader", 1);
  setenv("AWS_SECRET_ACCESS_KEY", "a secret", 1);
  EXPECT_EQ(digests(open_dataset("s3://volumes/noise.mtd", files())), expected_);
  EXPECT_TRUE(is_folder_of_datasets("s3://volumes/"));
  EXPECT_EQ(datasets_in("s3://volumes/"), std::vector<std::string>{"s3://volumes/noise.mtd"});
  for (const char* const name :
       {"AWS_ENDPOINT_URL", "AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"}) {
    unsetenv(name);
  }
}

TEST_F(RemoteDatasets, RetryTransientFailures) {
  for (const char* const lie : {"503/1", "truncated/1", "lost/1", "long/1", "wrong-range/2"}) {
    EXPECT_EQ(digests(open_dataset(address(std::string("/lies/") + lie), files())), expected_)
        << lie;
  }
}

TEST_F(RemoteDatasets, ReportPermanentFailures) {
  for (const char* const lie :
       {"503/1000", "truncated/1000", "lost/1000", "wrong-range/1000", "wrong-bytes/1000"}) {
    std::string text = "none";
    try {
      text = failure(open_dataset(address(std::string("/lies/") + lie), files()));
    } catch (const StoreError& error) {
      text = error.what();
    } catch (const DatasetFileError& error) {
      text = error.what();
    }
    EXPECT_NE(text.find(server_.address()), std::string::npos) << lie << ": " << text;
  }
}

TEST_F(RemoteDatasets, ReturnTheOldSurfaceOrAnErrorForReplacedFiles) {
  for (const char* const server : {"", "/no-conditions", "/no-etag"}) {
    prepare_noise(2);
    const auto opened = files();
    const DatasetPtr dataset = open_dataset(address(server), opened);
    prepare_noise(3);
    std::filesystem::last_write_time(
        folder_.path() / "noise.mtd",
        std::filesystem::file_time_type::clock::now() + std::chrono::seconds(9));
    const std::string text = failure(dataset);
    EXPECT_NE(text.find("has been replaced"), std::string::npos) << server << ": " << text;
    EXPECT_NE(digests(open_dataset(address(server), opened)), expected_);
  }
}

TEST_F(RemoteDatasets, AreServedFromTheDiskCache) {
  const std::filesystem::path kept = folder_.path() / "cache";
  EXPECT_EQ(digests(open_dataset(address(), files(kept))), expected_);
  const auto again = files(kept);
  EXPECT_EQ(digests(open_dataset(address(), again)), expected_);
  EXPECT_EQ(again->counts().requests, 1U) << "That of the opening.";
}

// Checks what a first preview of a remote dataset costs.
TEST_F(RemoteDatasets, FetchLittleForAFirstPreview) {
  prepare(*source_of(fields::gyroid(200, 0.2, 7)), {.name = "large"}, folder_.path() / "large.mtd",
          {});
  const auto opened = std::make_shared<RemoteFiles>();
  const DatasetPtr dataset = open_dataset(server_.address() + "/large.mtd", opened);
  EXPECT_EQ(opened->counts().requests, 1U);
  const SurfaceExtractor extractor(dataset);
  // The spacing that plans choose: the finest spacing with little to fetch besides the opening.
  std::int32_t finest = 8;
  while (spectrum_bytes_to_fetch(*dataset, finest) > kFirstFetchedBytes) finest *= 2;
  EXPECT_LE(finest, 64);
  StepRequest step{.request = {.isovalue = 0.1}, .finest_spacing = finest};
  EXPECT_FALSE(extractor.extract(step, {}).tiles.empty());
  EXPECT_LE(opened->counts().requests, 3U);
  EXPECT_LE(opened->counts().fetched_bytes, 512U << 10);
}

}  // namespace
}  // namespace multitetra
