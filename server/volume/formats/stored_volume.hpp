// A volume as stored in its file: the header, and slices in the file's own type. Every reader of a
// format returns one; streamed_volume.hpp turns it into a VolumeSource.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/affine.hpp"
#include "common/image/stored_type.hpp"
#include "common/request/physical_meaning.hpp"
#include "server/volume/formats/volume_contents.hpp"

namespace multitetra {

// A volume file that cannot be read or written. The text names the file, the problem and a remedy.
class VolumeFileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Throws VolumeFileError: "Cannot read '<file>': <problem>. <remedy>."
[[noreturn]] void fail_reading(const std::filesystem::path& file, const std::string& problem,
                               const std::string& remedy);

struct ImageHeader {
  std::array<std::int64_t, 3> dims = {1, 1, 1};  // From the file, not validated.
  StoredType type = StoredType::kU8;
  Vec3 spacing = {1, 1, 1};
  Affine index_to_world = {};
  PhysicalMeaning meaning = {};
  std::int64_t components = 1;  // Numbers of a sample, one after the other.
  // value = slope * stored + intercept; slope is not 0, both are finite.
  double slope = 1;
  double intercept = 0;
  // For an integer, where the file guarantees fewer bits than its type has; 0: all.
  int stored_bits = 0;
  std::optional<double> missing = std::nullopt;  // A stored number that means void.

  // Bytes of one slice as stored. Requires dims and components within their limits.
  [[nodiscard]] std::size_t slice_bytes() const {
    return static_cast<std::size_t>(dims[0] * dims[1] * components) * bytes_of(type);
  }
};

// Slices of a volume in the type they have in their files.
class StoredSlices {
 public:
  virtual ~StoredSlices() = default;
  // The slices first ... first + count - 1, in the byte order of this machine. Throws
  // VolumeFileError.
  virtual void read(std::size_t first, std::size_t count, std::byte* into) = 0;
  // Notices about the slices that were read, a sentence each.
  [[nodiscard]] virtual std::vector<std::string> findings() const { return {}; }
};

struct StoredVolume {
  ImageHeader header = {};
  std::unique_ptr<StoredSlices> slices = nullptr;
  std::vector<std::string> notices = {};  // Notices about reading the volume.
  VolumeContents members = {};
  std::int64_t channels = 1;  // The number of channels for VolumeChoice::channel.
  // The component that is the chosen time, where a sample has a number for each.
  std::optional<int> component_of_time = std::nullopt;
};

// Which of the numbers of a sample becomes its value, where it has several.
struct ComponentChoice {
  enum class Kind { kOnlyOne, kIndex, kMagnitude, kLuminance };
  Kind kind = Kind::kOnlyOne;
  int index = 0;

  // "magnitude", "luminance" (of red, green, blue as BT.709 weighs them) or a number from 0 on;
  // nullopt for anything else.
  [[nodiscard]] static std::optional<ComponentChoice> from(std::string_view text);

  friend bool operator==(const ComponentChoice&, const ComponentChoice&) = default;
};

// The choice of a volume in a source that holds several.
struct VolumeChoice {
  std::string array = {};  // The path or name of an array inside the source.
  // The level of a pyramid; 0 is the finest.
  std::optional<std::int64_t> level = std::nullopt;
  std::optional<std::int64_t> time = std::nullopt;     // From 0 on.
  std::optional<std::int64_t> channel = std::nullopt;  // From 0 on.
  std::string series = {};  // DICOM: a series' UID, or its number from 1 on.
  ComponentChoice component = {};
  bool follow = false;    // Data files may lie outside the folder of the header that names them.
  bool resample = false;  // DICOM: uneven and tilted slices are interpolated to a rectangular grid.
  // If there are several and none is chosen, take the first: for listing what there is.
  bool first = false;

  friend bool operator==(const VolumeChoice&, const VolumeChoice&) = default;
};

// The time that is chosen of `count`; 0 where there is one only. Throws VolumeFileError when there
// are several and none is chosen, or one that is not there.
[[nodiscard]] std::int64_t chosen_time(const std::filesystem::path& file, std::int64_t count,
                                       const VolumeChoice& choice);

// The largest number of samples along a side of a volume; what a larger grid would hold is refused.
inline constexpr std::int64_t kMaxSide = (std::int64_t{1} << 14) + 1;
inline constexpr std::int64_t kMaxComponents = 64;

// Throws unless dims and components are within the limits, the type's bits are, and the slope, the
// intercept, spacing and directions are finite and not degenerate.
void check_header(const std::filesystem::path& file, const ImageHeader& header);

// Sets index_to_world from an origin and orthogonal axes of length `spacing`.
void set_box_axes(ImageHeader& header, const Vec3& origin, const Vec3& spacing);

// Sets spacing and index_to_world from the steps between samples in world coordinates. Throws when
// the steps are not at right angles to each other (by more than 1 part in 1000): lengths of errors
// would not be those of the world.
void set_axes(const std::filesystem::path& file, ImageHeader& header,
              const std::array<Vec3, 3>& steps, const Vec3& origin);

// `text` if it can be a unit, else empty; common spellings of lengths become their symbols
// ("millimeter" or "millimeters": "mm", "um" or "microns": "µm").
[[nodiscard]] std::string unit_from(std::string_view text);

// A data file that a header names: `name` as seen from the header's folder. Throws when it leads
// out of that folder (unless choice.follow) or is no regular file.
[[nodiscard]] std::filesystem::path named_data_file(const std::filesystem::path& header,
                                                    const std::string& name, bool follow);

}  // namespace multitetra
