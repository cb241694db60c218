// Replays the fuzzing corpora with any compiler and sanitizer, to keep findings fixed.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <ostream>
#include <string>

#include "tests/support/temporary_folder.hpp"

// Each harness is compiled with its own name in place of LLVMFuzzerTestOneInput.
using Harness = int(const std::uint8_t* data, std::size_t size);
extern "C" {
Harness fuzz_client_file, fuzz_client_message, fuzz_dataset_file, fuzz_dataset_pages, fuzz_frame,
    fuzz_http_request, fuzz_label_names, fuzz_mesh_file, fuzz_more_volumes, fuzz_packed_pixels,
    fuzz_sandbox_answer, fuzz_server_message, fuzz_shell, fuzz_shell_round_trip, fuzz_shell_tile,
    fuzz_store_answers, fuzz_tile, fuzz_tile_round_trip, fuzz_volume_file, fuzz_volume_metadata,
    fuzz_whole_dataset;
}

namespace multitetra {
namespace {

struct Case {
  const char* name;
  Harness* harness;

  friend void PrintTo(const Case& one, std::ostream* out) { *out << one.name; }
};

class FuzzCorpus : public testing::TestWithParam<Case> {};

TEST_P(FuzzCorpus, PassesItsHarness) {
  const std::string name = GetParam().name;
  const TemporaryFolder unpacked;
  const std::string packed = MULTITETRA_FUZZ_CORPORA "/" + name + ".tar.xz";
  ASSERT_EQ(
      std::system(("tar -xJf '" + packed + "' -C '" + unpacked.path().string() + "'").c_str()), 0)
      << "Could not unpack " << packed;
  std::size_t inputs = 0;
  for (const auto& entry : std::filesystem::directory_iterator(unpacked.path() / name)) {
    const std::string bytes = bytes_of_file(entry.path());
    SCOPED_TRACE(entry.path().filename());
    try {
      GetParam().harness(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    } catch (const std::exception& broken) {
      ADD_FAILURE() << broken.what();
    }
    ++inputs;
  }
  EXPECT_GT(inputs, 50);
}

#define MULTITETRA_HARNESS(name) \
  Case { #name, name }
INSTANTIATE_TEST_SUITE_P(
    Kept, FuzzCorpus,
    testing::Values(MULTITETRA_HARNESS(fuzz_client_file), MULTITETRA_HARNESS(fuzz_client_message),
                    MULTITETRA_HARNESS(fuzz_dataset_file), MULTITETRA_HARNESS(fuzz_dataset_pages),
                    MULTITETRA_HARNESS(fuzz_frame), MULTITETRA_HARNESS(fuzz_http_request),
                    MULTITETRA_HARNESS(fuzz_label_names), MULTITETRA_HARNESS(fuzz_mesh_file),
                    MULTITETRA_HARNESS(fuzz_more_volumes), MULTITETRA_HARNESS(fuzz_packed_pixels),
                    MULTITETRA_HARNESS(fuzz_sandbox_answer),
                    MULTITETRA_HARNESS(fuzz_server_message), MULTITETRA_HARNESS(fuzz_shell),
                    MULTITETRA_HARNESS(fuzz_shell_round_trip), MULTITETRA_HARNESS(fuzz_shell_tile),
                    MULTITETRA_HARNESS(fuzz_store_answers), MULTITETRA_HARNESS(fuzz_tile),
                    MULTITETRA_HARNESS(fuzz_tile_round_trip), MULTITETRA_HARNESS(fuzz_volume_file),
                    MULTITETRA_HARNESS(fuzz_volume_metadata),
                    MULTITETRA_HARNESS(fuzz_whole_dataset)),
    [](const auto& one) { return std::string(one.param.name); });
#undef MULTITETRA_HARNESS

}  // namespace
}  // namespace multitetra
