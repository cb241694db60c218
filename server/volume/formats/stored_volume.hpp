// A volume as stored in its file: the header, and slices in the file's type. Every reader of a
// format returns one; streamed_volume.hpp converts it to a VolumeSource.
#pragma once

#include <algorithm>
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

#include "common/dataset/length_units.hpp"
#include "common/dataset/physical_meaning.hpp"
#include "common/image/stored_type.hpp"
#include "server/volume/formats/slice_places.hpp"
#include "server/volume/formats/stated_geometry.hpp"
#include "server/volume/formats/stated_values.hpp"
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

// Throws the same for a file that is shorter than it says; the remedy is a complete copy.
[[noreturn]] void fail_incomplete(const std::filesystem::path& file, const std::string& problem);

// Throws the same for a file that contradicts itself or cannot be decoded, because it is damaged or
// was written so; the remedy is to compare it with another copy.
[[noreturn]] void fail_damaged(const std::filesystem::path& file, const std::string& problem);

struct ImageHeader {
  std::array<std::int64_t, 3> dims = {1, 1, 1};  // The file's, not validated.
  StoredType type = StoredType::kU8;
  ValueBasis values;  // No default: each reader says what it knows.
  StatedGeometry geometry = {};
  PhysicalMeaning meaning = {};  // `geometry` and `assumed` are set when the volume is settled.
  Vec3 turned_by = {1, 1, 1};   // Signs that turned the file's coordinates into those of `meaning`.
  std::int64_t components = 1;  // Interleaved numbers per sample.
  // value = slope * stored + intercept; slope is not 0, both are finite.
  double slope = 1;
  double intercept = 0;
  // Number of bits in use, if an integer is guaranteed to use fewer than its type has; 0 means all.
  int stored_bits = 0;
  // Stored numbers that mean void: these, and those outside of the valid range.
  std::vector<double> missing = {};
  std::optional<std::array<double, 2>> valid_range = std::nullopt;
  std::vector<Contradiction> contradictions = {};

  [[nodiscard]] bool has_void() const { return !missing.empty() || valid_range; }
  [[nodiscard]] bool is_void(double number) const {
    return std::find(missing.begin(), missing.end(), number) != missing.end() ||
           (valid_range && !(number >= (*valid_range)[0] && number <= (*valid_range)[1]));
  }

  // Returns the stored bytes of a slice. Requires dims and components within their limits.
  [[nodiscard]] std::size_t slice_bytes() const {
    return static_cast<std::size_t>(dims[0] * dims[1] * components) * bytes_of(type);
  }
  [[nodiscard]] std::uint64_t volume_bytes() const {
    return slice_bytes() * static_cast<std::uint64_t>(dims[2]);
  }
};

// The slices of a volume, in the type of the file.
class StoredSlices {
 public:
  virtual ~StoredSlices() = default;
  // Reads slices first to first + count - 1, in host byte order. Throws VolumeFileError.
  virtual void read(std::size_t first, std::size_t count, std::byte* into) = 0;
  // Returns notices about the slices read so far, a sentence each.
  [[nodiscard]] virtual std::vector<std::string> findings() const { return {}; }
};

struct StoredVolume {
  ImageHeader header;
  std::unique_ptr<StoredSlices> slices = nullptr;
  std::vector<std::string> notices = {};  // Notices about opening the volume.
  VolumeContents contents = {};
  std::int64_t channels = 1;  // Number of channels for VolumeChoice::channel.
  std::int64_t series = 1;    // Number of series or images for VolumeChoice::series.
  // The component of the chosen time, if samples have a component for each time.
  std::optional<int> component_of_time = std::nullopt;
  // If present, slices of the header's dims are resampled to the grid of these places, whose axes
  // the header has.
  std::optional<SlicePlaces> resampled = std::nullopt;
};

// The choice of the component of a sample that becomes its value.
struct ComponentChoice {
  enum class Kind { kOnlyOne, kIndex, kMagnitude, kLuminance };
  Kind kind = Kind::kOnlyOne;
  int index = 0;

  // Parses "magnitude", "luminance" (of red, green, blue with the weights of BT.709) or a number
  // from 0; returns nullopt for anything else.
  [[nodiscard]] static std::optional<ComponentChoice> from(std::string_view text);

  friend bool operator==(const ComponentChoice&, const ComponentChoice&) = default;
};

// What the user states about a file, so that the file need not: readers do not refuse it, nor warn,
// for the lack or the strangeness of these.
struct GivenFacts {
  bool spacing = false;
  bool origin = false;
  bool length_unit = false;

  friend bool operator==(const GivenFacts&, const GivenFacts&) = default;
};

// Selects a volume in a source with several.
struct VolumeChoice {
  std::string array = {};  // Path or name of an array in the source.
  // Level of a pyramid; 0 is the finest.
  std::optional<std::int64_t> level = std::nullopt;
  std::optional<std::int64_t> time = std::nullopt;     // Counted from 0.
  std::optional<std::int64_t> channel = std::nullopt;  // Counted from 0.
  // DICOM: UID of a series, or its number from 1. OME-TIFF, OME-Zarr: an image's name, or its
  // number from 1.
  std::string series = {};
  ComponentChoice component = {};
  bool allow_external_files = false;  // Allows data files outside the folder of their header.
  bool resample = false;    // Resamples uneven and tilted slices and sheared grids to an even grid.
  bool nearest = false;     // Takes the nearest sample for that, as labels require; 0 outside.
  double subtract = 0;      // Subtracted from all values, in double precision.
  bool allow_loss = false;  // Accepts any loss by conversion to f32.
  // Takes the first of several if none is chosen; for listing contents.
  bool first = false;
  GivenFacts given = {};
  // The file that led to the source and describes it; set by readers.
  std::filesystem::path described_by = {};

  friend bool operator==(const VolumeChoice&, const VolumeChoice&) = default;
};

// Entries of a file of which one is chosen, such as its times.
struct FileEntries {
  std::int64_t count = 1;
  std::string several;                     // The problem if none is chosen: "it has 3 channels".
  std::string remedy;                      // Against that.
  std::string missing = "it has no time";  // Before the number of an entry that does not exist.
};
inline constexpr const char* kChooseTime =
    "Choose one with --time, from 0, or prepare them with --all-times";
inline constexpr const char* kChooseChannel =
    "Choose one with --channel, from 0, or prepare them with --field all";

// Returns the wanted entry, or the first if there is only one or `takes_first`. Throws
// VolumeFileError if there are several and none is wanted, or an invalid one.
[[nodiscard]] std::int64_t chosen_entry(const std::filesystem::path& file,
                                        const FileEntries& entries,
                                        std::optional<std::int64_t> wanted, bool takes_first);
// Returns the chosen one of `count` volumes, one for each time.
[[nodiscard]] std::int64_t chosen_time(const std::filesystem::path& file, std::int64_t count,
                                       const VolumeChoice& choice);

// Maximum number of samples along a side of a volume, set by the largest grid.
inline constexpr std::int64_t kMaxSide = (std::int64_t{1} << 14) + 1;
inline constexpr std::int64_t kMaxComponents = 64;

// Throws VolumeFileError unless dims, components and stored bits are within limits, slope and
// intercept are finite, and axes are not degenerate.
void check_header(const std::filesystem::path& file, const ImageHeader& header);

// The notice of a choice that nobody made, for StoredVolume::notices: "'a.vti': of its 3 arrays,
// 'p' is used; select another with --array."
[[nodiscard]] std::string choice_notice(const std::filesystem::path& file, std::size_t count,
                                        const std::string& kind, const std::string& used,
                                        const std::string& option);

// Lists the images of which choice.series chooses one, and notes which is used if it does not.
void offer_images(const std::filesystem::path& file, const std::string& kind,
                  const std::vector<std::string>& images, const VolumeChoice& choice,
                  StoredVolume& volume);

// Notes that numbers are indices of a color palette.
void note_palette(ImageHeader& header);

// The notice of bytes that follow what is read of a file.
[[nodiscard]] std::string unread_notice(const std::filesystem::path& file, std::uint64_t bytes);

// Converts a placement from RAS to LPS.
void ras_to_lps(ImageHeader& header, std::array<Vec3, 3>& steps, Vec3& origin);

// Returns the data file or folder `name`, relative to the header's folder. Throws if it is missing,
// or outside of that folder (unless `allow_external_files`).
[[nodiscard]] std::filesystem::path named_data_place(const std::filesystem::path& header,
                                                     const std::string& name,
                                                     bool allow_external_files);
// Returns the same for a data file, which must be a regular file.
[[nodiscard]] std::filesystem::path named_data_file(const std::filesystem::path& header,
                                                    const std::string& name,
                                                    bool allow_external_files);

}  // namespace multitetra
