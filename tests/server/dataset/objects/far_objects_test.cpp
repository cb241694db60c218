// A dataset behind HTTP gives the surfaces of the file, or says why it cannot.
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "common/mesh/content_digest.hpp"
#include "server/dataset/objects/convert_dataset.hpp"
#include "server/dataset/objects/object_dataset.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "tests/support/folder_server.hpp"
#include "tests/support/prepared_fields.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

namespace fields = testing::fields;

class FarObjects : public ::testing::Test {
 protected:
  FarObjects() : server_(folder_.path()) {
    const std::filesystem::path file = folder_.path() / "noise.mtd";
    prepare(*source_of(fields::integer_noise({140, 40, 40}, 90, 2)), {.name = "noise"}, file, {});
    file_to_objects(file, folder_.path() / "noise", false);
    expected_ = digests(open_dataset(file));
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
  [[nodiscard]] std::shared_ptr<ObjectCache> cache(const std::filesystem::path& folder = {}) const {
    return std::make_shared<ObjectCache>(
        ObjectCacheOptions{.memory_bytes = 3 << 20,
                           .folder = folder,
                           .far = {.tries = 3,
                                   .first_pause = std::chrono::milliseconds(1),
                                   .longest_pause = std::chrono::milliseconds(5),
                                   .deadline = std::chrono::milliseconds(2000)}});
  }
  [[nodiscard]] std::string address(const std::string& lie = "") const {
    return server_.address() + lie + "/noise";
  }

  const TemporaryFolder folder_;
  const FolderServer server_;
  std::vector<ContentDigest> expected_;
};

TEST_F(FarObjects, GiveTheSurfacesOfTheFile) {
  ASSERT_FALSE(expected_.empty());
  EXPECT_EQ(digests(open_objects(address(), cache())), expected_);
  EXPECT_NO_THROW(verify_objects(address(), cache()));
}

TEST_F(FarObjects, MayLieBesideTheirDataset) {
  file_to_shared_objects(folder_.path() / "noise.mtd", folder_.path() / "store" / "noise");
  const std::string store = server_.address() + "/store/noise";
  for (const std::string& place : {store, store + "/"}) {
    EXPECT_EQ(digests(open_objects(place, cache())), expected_);
    EXPECT_NO_THROW(verify_objects(place, cache()));
  }
}

TEST_F(FarObjects, AreReadFromBucketsWithSignedRequests) {
  setenv("AWS_ENDPOINT_URL", (server_.address() + "/s3").c_str(), 1);
  EXPECT_ANY_THROW((void)open_objects("s3://volumes/noise", cache()));  // Nobody signs yet.
  setenv("AWS_ACCESS_KEY_ID", "reader", 1);
  setenv("AWS_SECRET_ACCESS_KEY", "a secret", 1);
  EXPECT_EQ(digests(open_objects("s3://volumes/noise", cache())), expected_);
  for (const char* const name :
       {"AWS_ENDPOINT_URL", "AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"}) {
    unsetenv(name);
  }
}

TEST_F(FarObjects, GiveThemThroughTroubleThatPasses) {
  for (const char* const lie : {"503/1", "truncated/1", "lost/1"}) {
    EXPECT_EQ(digests(open_objects(address(std::string("/lies/") + lie), cache())), expected_)
        << lie;
  }
}

TEST_F(FarObjects, SayWhyThereIsNoSurfaceAndNeverGiveAnother) {
  for (const char* const lie : {"503/1000", "truncated/1000", "lost/1000", "wrong-bytes/1000"}) {
    std::string told = "nothing";
    try {
      (void)digests(open_objects(address(std::string("/lies/") + lie), cache()));
    } catch (const StoreError& error) {
      told = error.what();
    } catch (const DatasetFileError& error) {
      told = error.what();
    }
    EXPECT_NE(told.find(server_.address()), std::string::npos) << lie << ": " << told;
  }
}

TEST_F(FarObjects, AreServedFromTheDiskWhenTheStoreIsGone) {
  const std::filesystem::path kept = folder_.path() / "cache";
  const DatasetPtr before = open_objects(address(), cache(kept));
  EXPECT_EQ(digests(before), expected_);
  // Only the manifest comes from the store now.
  std::filesystem::rename(folder_.path() / "noise" / "objects", folder_.path() / "away");
  EXPECT_EQ(digests(open_objects(address(), cache(kept))), expected_);
  EXPECT_THROW((void)digests(open_objects(address(), cache())), DatasetFileError);
}

}  // namespace
}  // namespace multitetra
