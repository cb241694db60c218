#include "server/dataset/small_sections.hpp"

#include <cmath>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "server/core/spectrum/prepared_volume.hpp"
#include "server/dataset/byte_source.hpp"

namespace multitetra {
namespace {

[[noreturn]] void fail_on(const std::filesystem::path& file, const char* section,
                          const std::string& what) {
  throw DatasetFileError("'" + file.string() + "': Section \"" + section + "\": " + what +
                         " Prepare the dataset again.");
}

void check_size(const std::filesystem::path& file, const char* section, std::uint64_t bytes,
                std::uint64_t needed) {
  if (bytes == needed) return;
  fail_on(file, section,
          "it has " + std::to_string(bytes) + " bytes, and the metadata's dims and type need " +
              std::to_string(needed) + ".");
}

}  // namespace

void check_small_sections(const std::filesystem::path& place, const DatasetInfo& info,
                          std::uint64_t coarse_bytes, std::uint64_t ranges_bytes) {
  const auto width = static_cast<std::uint64_t>(bytes_per_sample(info.type));
  check_size(place, "coarse", coarse_bytes, width * coarse_extent(info).size());
  check_size(place, "ranges", ranges_bytes, 2 * width * cell_extent(info).size());
}

IsovalueBins bins_of(const std::filesystem::path& file, std::span<const std::byte> bytes) {
  std::vector<float> edges(bytes.size() / sizeof(float));
  if (bytes.size() % sizeof(float) != 0 || edges.size() > IsovalueBins::kMaxCount + 1 ||
      edges.size() == 1) {
    fail_on(file, "bins",
            "it has " + std::to_string(bytes.size()) + " bytes; it must have none, or 8 to " +
                std::to_string(sizeof(float) * (IsovalueBins::kMaxCount + 1)) + " in fours.");
  }
  if (!edges.empty()) std::memcpy(edges.data(), bytes.data(), bytes.size());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (!std::isfinite(edges[i]) || (i > 0 && edges[i] <= edges[i - 1])) {
      fail_on(file, "bins", "its edges are not finite numbers that increase.");
    }
  }
  return IsovalueBins(std::move(edges));
}

}  // namespace multitetra
