// Raw samples without a header of a known format. The caller, a text file beside them, three
// numbers before them, or the file's name gives their layout.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "server/volume/formats/endian.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// The layout of samples in a file, x fastest.
struct RawLayout {
  std::array<std::int32_t, 3> dims{};  // Samples along x, y, z; each at least 1.
  StoredType type = StoredType::kU8;
  Endian endian = Endian::kLittle;
  std::uint64_t header_bytes = 0;  // Bytes before the first sample.
};

// Opens a file of samples, optionally compressed by gzip or bzip2. Throws VolumeFileError unless
// its size matches the layout exactly.
[[nodiscard]] StoredVolume open_raw(const std::filesystem::path& file, const RawLayout& layout);

struct DescribedRaw {
  // The file of samples, optionally compressed by gzip or bzip2.
  std::filesystem::path file;
  // The origin of the layout, for a notice.
  std::string source;
  std::uint64_t offset = 0;
  // A gzip stream of samples begins at `offset`.
  bool begins_packed = false;
  Endian endian = Endian::kLittle;
  ImageHeader header = {.values = kNumbersAsStored};
};

// Returns whether a text with this beginning describes raw samples: a .dat header of volvis.org,
// with the lines "ObjectFileName: NAME" and "Resolution: X Y Z".
[[nodiscard]] bool is_raw_description(std::string_view beginning);

// Parses the description `file`. Throws VolumeFileError.
[[nodiscard]] DescribedRaw described_raw(const std::filesystem::path& file,
                                         bool allow_external_files);

// Finds the layout of raw samples: in a .dat or .txt file of the same name; in three 16-bit counts
// before exactly as many 16-bit samples; or in a name such as fuel_64x64x64_uint8.raw. Returns
// nullopt if there is none of these. A layout always matches the length of the file, if that is
// known. Throws VolumeFileError if a description contradicts the file.
[[nodiscard]] std::optional<DescribedRaw> layout_of_raw(const std::filesystem::path& file);

[[nodiscard]] StoredVolume open_described(const DescribedRaw& raw);

}  // namespace multitetra
