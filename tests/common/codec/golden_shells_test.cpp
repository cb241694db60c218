// Guards the format against accidental changes: tests/golden/shell_*.bin are the encoder's output,
// and shells.txt is what all decoders, in C++, Python and WebAssembly, give for it ("name vertices
// triangles checksum", see tests/support/golden_shells.hpp).
//
// After a deliberate change: MULTITETRA_WRITE_GOLDEN=1 codec_test --gtest_filter='GoldenShells.*'

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/golden_shells.hpp"

namespace multitetra {
namespace {

using testing::checksum;
using testing::decode_shell;
using testing::DecodedShell;
using testing::golden_shells;
using testing::GoldenShell;

const std::string kFolder = MULTITETRA_TEST_DATA "/";

std::string file_bytes(const std::string& name) {
  std::ifstream in(kFolder + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

TEST(GoldenShells, MatchEncoderAndDecoder) {
  const bool write = std::getenv("MULTITETRA_WRITE_GOLDEN") != nullptr;
  std::ostringstream listing;
  for (const GoldenShell& golden : golden_shells()) {
    SCOPED_TRACE(golden.name);
    const auto bytes = shell::encode_shell(golden.box.box(), golden.options);
    ASSERT_TRUE(bytes) << bytes.error().text;
    const std::string as_text(bytes->begin(), bytes->end());
    if (write)
      std::ofstream(kFolder + "shell_" + golden.name + ".bin", std::ios::binary) << as_text;
    const std::string kept = file_bytes("shell_" + golden.name + ".bin");
    EXPECT_EQ(as_text, kept);
    const DecodedShell decoded = decode_shell({kept.begin(), kept.end()});
    ASSERT_EQ(decoded.status, shell::ShellStatus::kOk);
    EXPECT_GT(decoded.mesh.triangles.size(), 0U);
    listing << golden.name << " " << decoded.mesh.vertices.size() << " "
            << decoded.mesh.triangles.size() << " " << std::hex << checksum(decoded.mesh)
            << std::dec << "\n";
  }
  if (write) std::ofstream(kFolder + "shells.txt") << listing.str();
  EXPECT_EQ(listing.str(), file_bytes("shells.txt"));
}

}  // namespace
}  // namespace multitetra
