// Raw samples whose layout is not in a header of a known format: given by the caller, in a text
// file beside them, in three numbers before them, or in the file's name.
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

// Where the samples are in a file without a header of its own, x fastest.
struct RawLayout {
  std::array<std::int32_t, 3> dims{};  // Samples along x, y, z; each at least 1.
  StoredType type = StoredType::kU8;
  Endian endian = Endian::kLittle;
  std::uint64_t header_bytes = 0;  // Bytes before the first sample.
  Vec3 spacing = {1, 1, 1};        // World units between samples, > 0.
};

// The samples of a file, which may be packed by gzip or bzip2. Throws VolumeFileError unless it has
// exactly the bytes that the layout needs.
[[nodiscard]] StoredVolume open_raw(const std::filesystem::path& file, const RawLayout& layout);

struct DescribedRaw {
  // The file of samples, which may be packed (gzip, bzip2).
  std::filesystem::path file;
  // Where the layout was found, for a notice.
  std::string source;
  std::uint64_t offset = 0;
  bool begins_packed = false;  // A gzip stream of the samples begins at `offset` of the file.
  Endian endian = Endian::kLittle;
  ImageHeader header = {};
};

// Whether a text that begins so describes raw samples: the .dat headers of volvis.org, with the
// lines "ObjectFileName: NAME" and "Resolution: X Y Z".
[[nodiscard]] bool is_raw_description(std::string_view beginning);

// Parses the description `file`. Throws VolumeFileError.
[[nodiscard]] DescribedRaw described_raw(const std::filesystem::path& file, bool follow);

// The layout of raw samples: from a .dat or .txt of the same name beside them; from three 16-bit
// counts in front of exactly as many 16-bit samples; or from a name such as
// fuel_64x64x64_uint8.raw. nullopt without any of these. Where the length of the file is known, the
// layout agrees with it. Throws VolumeFileError when a description contradicts the file.
[[nodiscard]] std::optional<DescribedRaw> layout_of_raw(const std::filesystem::path& file);

[[nodiscard]] StoredVolume open_described(const DescribedRaw& raw);

}  // namespace multitetra
