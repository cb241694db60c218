// Any bytes are rejected or are a prepared dataset whose bricks can be read: each is intact or
// rejected, and all are intact if the verification finds no damage.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "common/mesh/checksum.hpp"
#include "server/dataset/prepared_bricks.hpp"
#include "server/dataset/verify_dataset.hpp"
#include "tests/fuzz/dataset_file_input.hpp"
#include "tests/fuzz/require.hpp"
#include "tests/support/memory_source.hpp"

namespace {

using namespace multitetra;

// Returns whether all bricks are intact.
bool look_at_all(const PreparedBricks& source) {
  bool whole = true;
  for (std::size_t i = 0; i < source.size(); ++i) {
    try {
      std::uint64_t sum = 0;
      for (const std::byte byte : source.brick(i)) sum += static_cast<std::uint64_t>(byte);
      require(sum <= 255 * std::uint64_t{source.brick(i).size()});
    } catch (const DatasetFileError&) {
      whole = false;
    }
  }
  return whole;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string file = dataset_file_of({reinterpret_cast<const char*>(data), size});
  const auto bytes = std::as_bytes(std::span(file));
  const Result<void> verified = verify_bytes(MemorySource(bytes));
  auto decoded = decode_structure(MemorySource(bytes));
  require(decoded.has_value() || !verified);
  if (!decoded) return 0;
  const BrickFile opened = {
      .place = "memory",
      .source = std::make_shared<const MemorySource>(bytes),
      .structure = std::make_shared<const PreparedStructure>(*std::move(decoded)),
      .cache = std::make_shared<MemoryCache>(std::size_t{1} << 20)};
  const bool samples = look_at_all(SampleBricks(opened));
  const bool spectrum = look_at_all(SpectrumBricks(opened));
  require((samples && spectrum) || !verified);
  return 0;
}
