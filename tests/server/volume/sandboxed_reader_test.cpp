// A reader's crash in its process becomes an error of the caller: with readers made to fail, and
// with files that crash the libraries of two formats (golden/crashes.txt).
#include "server/volume/detail/sandboxed_reader.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "common/sandbox/packed.hpp"
#include "server/volume/volume_files.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/texts.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;
using testing::expect_contains;

// Slices of 2 x 2 samples; calls `reading` before each slab is read.
class FailingSource : public VolumeSource {
 public:
  explicit FailingSource(std::function<void()> reading, std::int32_t slices = 2)
      : reading_(std::move(reading)) {
    header_.dims = {2, 2, slices};
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

using OpenedSource = std::unique_ptr<VolumeSource>;

const SandboxTask kAbort = reading(
    "test: abort",
    [](const std::string&, const Notice&, const HeaderIsKnown&) -> OpenedSource { std::abort(); });
const SandboxTask kAbortLater = reading(
    "test: abort later",
    [](const std::string&, const Notice&, const HeaderIsKnown& header_is_known) -> OpenedSource {
      header_is_known(0);
      return std::make_unique<FailingSource>([slabs = 0]() mutable {
        if (++slabs == 2) std::abort();
      });
    });
const SandboxTask kTenSlices = reading(
    "test: ten slices",
    [](const std::string&, const Notice&, const HeaderIsKnown& header_is_known) -> OpenedSource {
      header_is_known(0);
      return std::make_unique<FailingSource>([] {}, 10);
    });
// The request is a number of GiB.
const SandboxTask kTake =
    reading("test: take memory",
            [](const std::string& request, const Notice&,
               const HeaderIsKnown& header_is_known) -> OpenedSource {
              header_is_known(0);
              return std::make_unique<FailingSource>([gib = std::stoul(request)] {
                // Reserves the memory, and uses one byte of it.
                const auto memory = std::make_unique_for_overwrite<std::byte[]>(gib << 30);
                static_cast<volatile std::byte*>(memory.get())[0] = std::byte{1};
              });
            });
// A reader that untrusted bytes have taken over: sends the request as a message of its first byte.
const SandboxTask kLie = {"test: lie", [](SandboxChannel& parent, const std::string& request) {
                            for (int i = 0; i < 20'000; ++i) {
                              if (!parent.send(request[0], request.substr(1))) return;
                            }
                          }};

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

OpenedSource opened(const fs::path& path, const SandboxTask& task,
                    const std::string& request = {}) {
  return sandboxed_volume(path, task, {}, request, nullptr);
}

TEST(SandboxedVolume, ReportsACrashWhileOpening) {
  const std::string sentence = sentence_of([&] { (void)opened("a.dcm", kAbort); });
  expect_contains(sentence, "Cannot read 'a.dcm'");
  expect_contains(sentence, "its reader crashed (Aborted)");
  expect_contains(sentence, "damaged");
}

TEST(SandboxedVolume, ReportsACrashWhileReading) {
  const auto source = opened("a.h5", kAbortLater);
  Samples samples;
  source->read(1, 1, samples);
  EXPECT_EQ(std::get<std::vector<std::uint8_t>>(samples), std::vector<std::uint8_t>(4, 1));
  expect_contains(sentence_of([&] { source->read(0, 1, samples); }),
                  "its reader crashed (Aborted)");
}

TEST(SandboxedVolume, ReadsInAnyOrder) {
  const auto source = opened("a.dcm", kTenSlices);
  Samples samples;
  for (const auto& [first, slices] : {std::pair(0, 4),
                                      {4, 4},
                                      {8, 2},
                                      {0, 4},
                                      {4, 4},
                                      {2, 3},
                                      {5, 3},
                                      {9, 1},
                                      {0, 1},
                                      {1, 1},
                                      {0, 10}}) {
    source->read(first, slices, samples);
    EXPECT_EQ(std::get<std::vector<std::uint8_t>>(samples),
              std::vector<std::uint8_t>(static_cast<std::size_t>(slices) * 4,
                                        static_cast<std::uint8_t>(first)));
  }
}

TEST(SandboxedVolume, RefusesAnswersThatNoReaderGives) {
  VolumeHeader header;
  header.dims = {2, 2, 2};
  const auto message = [](const VolumeHeader& of) {
    return "o" + packed_values(of.dims, of.type, of.spacing, of.index_to_world, of.meaning.space,
                               of.meaning.length_unit, of.meaning.value_unit, of.meaning.geometry,
                               of.meaning.assumed, of.values);
  };
  EXPECT_EQ(opened("a", kLie, message(header))->header().dims, header.dims);
  std::vector<std::string> lies = {"o",  "k",      "kfar too long", "m", "m{}",
                                   "m[", "nagain", "r\x1b[2J",      "x"};
  const auto add = [&](const std::function<void(VolumeHeader&)>& change) {
    VolumeHeader other = header;
    change(other);
    lies.push_back(message(other));
  };
  add([](VolumeHeader& h) { h.dims[1] = 0; });
  add([](VolumeHeader& h) { h.dims[2] = 2'000'000'000; });
  add([](VolumeHeader& h) { h.type = static_cast<SampleType>(7); });
  add([](VolumeHeader& h) { h.spacing[0] = std::nan(""); });
  add([](VolumeHeader& h) { h.index_to_world.translation[2] = HUGE_VAL; });
  add([](VolumeHeader& h) { h.meaning.space = static_cast<WorldSpace>(-1); });
  add([](VolumeHeader& h) { h.meaning.length_unit = "\x1b[2J"; });
  add([](VolumeHeader& h) { h.meaning.geometry = static_cast<GeometryBasis>(4); });
  add([](VolumeHeader& h) { h.meaning.assumed = "\x1b[2J"; });
  add([](VolumeHeader& h) { h.values.assign(5000, 'x'); });
  for (const std::string& lie : lies) {
    expect_contains(sentence_of([&] { (void)opened("a", kLie, lie); }),
                    "does not answer as a reader does");
  }
  expect_contains(sentence_of([&] { (void)opened("a", kLie, "f\x1b[2J"); }), "\\x1b[2J");
}

// Sanitizers reserve more address space than the limit.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(SandboxedVolume, LimitsTheMemoryWhileReading) {
  Samples samples;
  opened("a.tif", kTake, "1")->read(0, 1, samples);
  expect_contains(sentence_of([&] { opened("a.tif", kTake, "7")->read(0, 1, samples); }), "memory");
}
#endif

// ---- files

TEST(SandboxedVolume, FollowsLinksOfTheSource) {
  const TemporaryFolder here;
  const TemporaryFolder there;
  there.file("annexed",
             "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\n12345678");
  fs::create_symlink(there.path() / "annexed", here.path() / "a.nrrd");
  EXPECT_EQ(read_volume(here.path() / "a.nrrd").dims[0], 2);
  here.file("b.nhdr",
            "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: " +
                (there.path() / "annexed").string() + "\n");
  expect_contains(sentence_of([&] { (void)read_volume(here.path() / "b.nhdr"); }), "--follow");
  there.file("raw", "12345678");
  here.file("c.nhdr",
            "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: " +
                (there.path() / "raw").string() + "\n");
  EXPECT_EQ(read_volume(here.path() / "c.nhdr", {.choice = {.allow_external_files = true}}).dims[0],
            2);
}

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
  expect_contains(sentence, "may be damaged");
}

TEST(SandboxedVolume, ReportsCrashesOfGdcm) { expect_crash_is_error("crashes_gdcm.dcm"); }

TEST(SandboxedVolume, ReportsCrashesOfHdf5) { expect_crash_is_error("crashes_hdf5_type.h5"); }

// HDF5 also crashes on chunks of the wrong size, so the reader refuses them first.
TEST(SandboxedVolume, RejectsAChunkThatCrashesHdf5) {
  // HDF5 1.14 refuses the chunk itself.
  const std::string sentence = sentence_about("crashes_hdf5.h5");
  const bool is_refused = sentence.find("part of its samples cannot be read") != std::string::npos;
  if (!is_refused) expect_contains(sentence, "its chunk at 0, 0, 0 does not have the");
}

}  // namespace
}  // namespace multitetra
