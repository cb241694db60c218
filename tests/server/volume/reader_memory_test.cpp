// Memory of reader processes for files whose headers declare much more than they contain.
#include <sys/resource.h>

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <string>

#include "server/volume/volume_files.hpp"
#include "tests/server/volume/written_volumes.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/texts.hpp"

// Sanitizers use additional memory.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace multitetra {
namespace {

namespace fs = std::filesystem;

// The peak resident memory of all child processes that have ended, in MiB.
long most_of_children() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  return usage.ru_maxrss / 1024;
}

TEST(ReaderMemory, LimitsHeaders) {
  // A DICOM file with an element of 3 GiB before its pixels. The file is sparse.
  const TemporaryFolder folder;
  std::string head(128, '\0');
  head += "DICM";
  const std::string syntax = std::string("1.2.840.10008.1.2.1") + '\0';
  std::string meta = std::string("\2\0\x10\0UI", 6);
  meta += packed<std::uint16_t>({static_cast<double>(syntax.size())}) + syntax;
  head += std::string("\2\0\0\0UL\4\0", 8) +
          packed<std::uint32_t>({static_cast<double>(meta.size())}) + meta;
  const double long_bytes = 3.0 * (1 << 30);
  head += std::string("\x09\0\x01\x10OB\0\0", 8) + packed<std::uint32_t>({long_bytes});
  const fs::path file = folder.file("long.dcm", head);
  fs::resize_file(file, head.size() + static_cast<std::uintmax_t>(long_bytes) + 100);
  try {
    (void)read_volume(file);
    ADD_FAILURE() << "it is read";
  } catch (const VolumeFileError& refused) {
    testing::expect_contains(refused.what(), "Cannot read");
  }
  EXPECT_LT(most_of_children(), 1500);
}

TEST(ReaderMemory, BoundsTheIndicesOfShardLayers) {
  // 256 shards, each of 2^18 chunks of one sample: indices of 4 MiB, a gigabyte together. Those of
  // the first slice mark their chunks as missing; the others are a hole in the file.
  const TemporaryFolder folder;
  folder.file("many.zarr/zarr.json",
              R"({"zarr_format":3,"node_type":"array","shape":[256,512,512],"data_type":"uint8",)"
              R"("chunk_grid":{"name":"regular","configuration":{"chunk_shape":[256,32,32]}},)"
              R"("chunk_key_encoding":{"name":"default"},"fill_value":7,"codecs":[)"
              R"({"name":"sharding_indexed","configuration":{"chunk_shape":[1,1,1],)"
              R"("codecs":[{"name":"bytes"}],"index_codecs":[{"name":"bytes"}]}}]})");
  const std::string missing(std::size_t{16} * 32 * 32, '\xFF');
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 16; ++x) {
      const fs::path shard =
          folder.file("many.zarr/c/0/" + std::to_string(y) + "/" + std::to_string(x), missing);
      fs::resize_file(shard, std::uintmax_t{16} * 256 * 32 * 32);
    }
  }
  {
    const auto source = open_volume((folder.path() / "many.zarr").string());
    Samples slice;
    source->read(0, 1, slice);
    EXPECT_EQ(std::get<std::vector<std::uint8_t>>(slice),
              std::vector<std::uint8_t>(std::size_t{512} * 512, 7));
  }
  EXPECT_LT(most_of_children(), 600);
}

}  // namespace
}  // namespace multitetra

#endif
