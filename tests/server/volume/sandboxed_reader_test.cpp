// A reader's crash in its process becomes an error of the caller: with readers made to fail, and
// with files that crash the libraries of two formats (golden/crashes.txt).
#include "server/volume/detail/sandboxed_reader.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>

#include "server/volume/volume_files.hpp"
#include "tests/support/texts.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;
using testing::expect_contains;

// Two slices of 2 x 2 samples; calls `reading` before each slab is read.
class FailingSource : public VolumeSource {
 public:
  explicit FailingSource(std::function<void()> reading) : reading_(std::move(reading)) {
    header_.dims = {2, 2, 2};
    header_.type = SampleType::kU8;
  }
  [[nodiscard]] const VolumeHeader& header() const override { return header_; }
  void read(std::int32_t first_slice, std::int32_t slices, Samples& into) override {
    reading_();
    into = std::vector<std::uint8_t>(static_cast<std::size_t>(slices) * 4,
                                     static_cast<std::uint8_t>(first_slice));
  }

 private:
  std::function<void()> reading_;
  VolumeHeader header_;
};

// Returns the message of the error that `action` throws.
std::string sentence_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const VolumeFileError& error) {
    return error.what();
  }
  ADD_FAILURE() << "it was read and should not have been";
  return {};
}

TEST(SandboxedVolume, ReportsACrashWhileOpening) {
  const OpenSource aborts =
      [](const Notice&, const HeaderIsKnown&) -> std::unique_ptr<VolumeSource> { std::abort(); };
  const std::string sentence =
      sentence_of([&] { (void)sandboxed_volume("a.dcm", aborts, nullptr); });
  expect_contains(sentence, "Cannot read 'a.dcm'");
  expect_contains(sentence, "its reader crashed (Aborted)");
  expect_contains(sentence, "damaged");
}

TEST(SandboxedVolume, ReportsACrashWhileReading) {
  int slabs = 0;
  const OpenSource aborts_later = [&](const Notice&, const HeaderIsKnown& header_is_known) {
    header_is_known(0);
    return std::make_unique<FailingSource>([&] {
      if (++slabs == 2) std::abort();
    });
  };
  const auto source = sandboxed_volume("a.h5", aborts_later, nullptr);
  Samples samples;
  source->read(1, 1, samples);
  EXPECT_EQ(std::get<std::vector<std::uint8_t>>(samples), std::vector<std::uint8_t>(4, 1));
  expect_contains(sentence_of([&] { source->read(0, 1, samples); }),
                  "its reader crashed (Aborted)");
}

// Sanitizers reserve more address space than the limit.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(SandboxedVolume, LimitsTheMemoryWhileReading) {
  const auto source_of = [](std::size_t gib) {
    const OpenSource takes = [gib](const Notice&, const HeaderIsKnown& header_is_known) {
      header_is_known(0);
      return std::make_unique<FailingSource>([gib] {
        // Reserves the memory, and uses one byte of it.
        const auto memory = std::make_unique_for_overwrite<std::byte[]>(gib << 30);
        static_cast<volatile std::byte*>(memory.get())[0] = std::byte{1};
      });
    };
    return sandboxed_volume("a.tif", takes, nullptr);
  };
  Samples samples;
  source_of(1)->read(0, 1, samples);
  expect_contains(sentence_of([&] { source_of(7)->read(0, 1, samples); }), "memory");
}
#endif

std::string sentence_about(const std::string& file) {
  const fs::path path = fs::path(MULTITETRA_TEST_DATA) / file;
  EXPECT_TRUE(fs::exists(path));
  const std::string sentence = sentence_of([&] { (void)read_volume(path); });
  expect_contains(sentence, "Cannot read '" + path.string() + "'");
  return sentence;
}

// Newer versions of the libraries may refuse the files themselves.
void expect_crash_is_error(const std::string& file) {
  const std::string sentence = sentence_about(file);
  if (sentence.find("crashed") == std::string::npos) {
    GTEST_SKIP() << "NOT TESTED: this version of the library refuses the file: " << sentence;
  }
  expect_contains(sentence, "its reader crashed (");
  expect_contains(sentence, "It is damaged");
}

TEST(SandboxedVolume, ReportsCrashesOfGdcm) { expect_crash_is_error("crashes_gdcm.dcm"); }

TEST(SandboxedVolume, ReportsCrashesOfHdf5) { expect_crash_is_error("crashes_hdf5_type.h5"); }

// HDF5 also crashes on chunks of the wrong size, so the reader refuses them first.
TEST(SandboxedVolume, RejectsAChunkThatCrashesHdf5) {
  expect_contains(sentence_about("crashes_hdf5.h5"), "its chunk at 0, 0, 0 does not have the");
}

}  // namespace
}  // namespace multitetra
