#include "server/volume/volume_files.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/address_text.hpp"
#include "common/base/number_text.hpp"
#include "common/base/open_file.hpp"
#include "common/sandbox/packed.hpp"
#include "server/store/http_store.hpp"
#include "server/volume/detail/readable_files.hpp"
#include "server/volume/detail/resampled_volume.hpp"
#include "server/volume/detail/sandboxed_reader.hpp"
#include "server/volume/detail/streamed_volume.hpp"
#include "server/volume/formats/described_raw.hpp"
#include "server/volume/formats/image_stack.hpp"
#include "server/volume/formats/volume_formats.hpp"
#include "server/volume/formats/vtk/pvd_file.hpp"

namespace multitetra {

inline auto fields(VolumeChoice& choice) {
  return std::tie(choice.array, choice.level, choice.time, choice.channel, choice.series,
                  choice.component, choice.allow_external_files, choice.resample, choice.nearest,
                  choice.first, choice.subtract, choice.allow_loss);
}
inline auto fields(Placement& placement) {
  return std::tie(placement.spacing, placement.orient, placement.origin, placement.space,
                  placement.length_unit);
}

namespace {

namespace fs = std::filesystem;

// Whether to open a volume slab by slab or to read it into memory.
enum class Use { kSlabs, kWhole };

// Throws unless the machine has the memory for all samples; called before the allocation.
void check_memory(const fs::path& file, const ImageHeader& header) {
  const std::int64_t bytes = header.dims[2] * static_cast<std::int64_t>(header.slice_bytes());
  const std::int64_t memory = std::int64_t{sysconf(_SC_PHYS_PAGES)} * sysconf(_SC_PAGESIZE);
  if (bytes > memory) {
    fail_reading(file,
                 "its " + sides_text(header.dims) + " samples need " + std::to_string(bytes) +
                     " bytes of memory, but this machine has " + std::to_string(memory),
                 "Reduce the volume or use a larger machine");
  }
}

// Returns the bytes of all samples: as stored, plus converted to at most 4 bytes each.
std::uint64_t whole_volume_bytes(const ImageHeader& header) {
  const auto samples = static_cast<std::uint64_t>(header.dims[0] * header.dims[1] * header.dims[2]);
  return header.slice_bytes() * static_cast<std::uint64_t>(header.dims[2]) + 4 * samples;
}

// Resamples a sheared grid if `resample` is set; throws otherwise.
void make_rectangular(const fs::path& file, bool resample, StoredVolume& volume) {
  if (volume.resampled || has_right_angles(volume.header)) return;
  if (!resample) check_right_angles(file, volume.header);
  check_header(file, volume.header);
  volume.resampled = straighten(volume.header);
  volume.notices.push_back(
      "'" + without_password(file.string()) +
      "': its axes are not at right angles to each other; --resample makes it a rectangular grid "
      "of " +
      sides_text(volume.resampled->dims) + " samples.");
}

// Returns the header of a volume after resampling.
ImageHeader header_on_grid(const StoredVolume& volume) {
  ImageHeader header = volume.header;
  if (volume.resampled) header.dims = volume.resampled->dims;
  return header;
}

// Parameters for opening a volume.
struct Opening {
  const VolumeFileOptions& options;
  Use use;
  const Notice& notice;
  const HeaderIsKnown& header_is_known;
};

ComponentChoice component_of(const VolumeChoice& choice) {
  const bool takes_first = choice.first && choice.component == ComponentChoice();
  return takes_first ? ComponentChoice{.kind = ComponentChoice::Kind::kIndex} : choice.component;
}

// Labels are compared one by one; see LabelMap.
AllowedLoss allowed_loss(const VolumeChoice& choice) {
  return choice.allow_loss || choice.nearest ? AllowedLoss::kAny : AllowedLoss::kHundredth;
}

// ---- opening any path

// Splits "file.h5:/path" into a file and a path inside it, unless a file has that name.
std::pair<fs::path, std::string> split_inner_path(const fs::path& path) {
  std::error_code error;
  const std::string text = path.string();
  const std::size_t colon = text.rfind(":/");
  if (colon == std::string::npos || colon == 0 || fs::exists(path, error)) return {path, {}};
  return {text.substr(0, colon), text.substr(colon + 1)};
}

std::string known_files() {
  std::string text;
  for (const VolumeFormat& format : volume_formats()) {
    text += (text.empty() ? "" : ", ") + std::string(format.name) + " (" +
            std::string(format.files) + ")";
  }
  return text;
}

// Throws if `choice` selects something that this format or file does not have. `format` is null for
// raw samples with a given layout.
void check_choice(const fs::path& path, const VolumeFormat* format, const VolumeChoice& choice,
                  const StoredVolume& volume) {
  const auto refuse = [&](const std::string& option, const std::string& what) {
    const ImageHeader& header = volume.header;
    fail_reading(path,
                 option + " does not apply: the file has no " + what + ", only one volume of " +
                     sides_text(header.dims) + " samples" +
                     (header.components > 1 && !volume.component_of_time
                          ? " of " + std::to_string(header.components) + " components"
                          : ""),
                 "Omit " + option);
  };
  if (!choice.array.empty() && !(format && format->has_arrays)) refuse("--array", "named arrays");
  if (choice.level && !(format && format->has_levels)) refuse("--level", "resolution levels");
  if (!choice.series.empty() && !(format && format->has_series) && volume.series <= 1) {
    refuse("--series", "series");
  }
  if (choice.time.value_or(0) != 0 && volume.contents.times.count <= 1) refuse("--time", "times");
  if (choice.channel.value_or(0) != 0 && volume.channels <= 1) refuse("--channel", "channels");
  const bool is_first = choice.component.kind == ComponentChoice::Kind::kOnlyOne ||
                        choice.component == ComponentChoice{ComponentChoice::Kind::kIndex, 0};
  if (!is_first && volume.header.components == 1) refuse("--component", "components");
}

// Returns the format of a volume that has no given layout. Throws if there is none.
const VolumeFormat& format_of(const fs::path& path) {
  if (is_address(path.string())) return format_of_addresses();
  if (!fs::exists(path)) {
    if (is_stack_pattern(path.filename().string())) return format_of_pattern(path);
    fail_reading(path, "the file does not exist", "Check the name");
  }
  if (is_pvd(path)) {
    fail_reading(path, "it is a collection of files, one for each time", "Give one of its files");
  }
  if (const VolumeFormat* const format = recognized_format(path)) return *format;
  if (fs::is_directory(path)) {
    fail_reading(path,
                 "this folder has neither images (TIFF, PNG, JPEG, DICOM) nor a Zarr or N5 array",
                 "Supported formats: " + known_files());
  }
  if (OpenFile(path).content(4) == "\x89MTD") {
    fail_reading(path, "it is already a prepared dataset",
                 "Serve it, or prepare the volume from which it was made");
  }
  fail_reading(
      path, "neither its content nor its name matches a supported format",
      "Supported formats: " + known_files() + "; give the layout of raw samples with --dims");
}

StoredVolume open_stored(const fs::path& path, const std::optional<RawLayout>& raw,
                         const VolumeChoice& choice) {
  if (raw && !fs::exists(path)) fail_reading(path, "the file does not exist", "Check the name");
  const VolumeFormat* const format = raw ? nullptr : &format_of(path);
  StoredVolume volume = raw ? open_raw(path, *raw) : format->open(path, choice);
  check_choice(path, format, choice, volume);
  if (volume.header.components > 1 && !volume.component_of_time) {
    const std::string count = std::to_string(volume.header.components);
    volume.contents.entries.push_back({.kind = "components",
                                       .name = count,
                                       .detail = {},
                                       .option = "--component, from 0, magnitude or luminance"});
  }
  return volume;
}

std::unique_ptr<VolumeSource> open_path(const fs::path& whole_path, const Opening& opening) {
  VolumeChoice choice = opening.options.choice;
  Placement placement = opening.options.placement;
  choice.given = {.spacing = placement.spacing.has_value(),
                  .origin = placement.origin.has_value(),
                  .length_unit = placement.length_unit.has_value()};
  auto [path, inside] = split_inner_path(whole_path);
  if (is_address(whole_path.string())) path = whole_path;
  if (path != whole_path) choice.array = inside;
  StoredVolume stored = open_stored(path, opening.options.raw, choice);
  // Spacings are those of the file's axes, which resampling may change.
  place(stored.header, {.spacing = std::exchange(placement.spacing, std::nullopt)});
  make_rectangular(path, choice.resample, stored);
  place(stored.header, placement);
  stored.header.intercept -= choice.subtract;
  const ImageHeader whole = header_on_grid(stored);
  check_header(path, whole);
  opening.header_is_known(opening.use == Use::kWhole ? whole_volume_bytes(whole) : 0);
  if (opening.use == Use::kWhole) check_memory(whole_path, whole);
  ComponentChoice component = component_of(choice);
  if (stored.component_of_time) {
    component = {.kind = ComponentChoice::Kind::kIndex, .index = *stored.component_of_time};
  }
  const std::optional<SlicePlaces> places = std::move(stored.resampled);
  std::unique_ptr<VolumeSource> volume =
      streamed_volume(without_password(whole_path.string()), std::move(stored), component,
                      allowed_loss(choice), opening.notice);
  if (!places) return volume;
  return resampled_volume(std::move(volume), *places,
                          choice.nearest ? Resampling::kNearest : Resampling::kLinear);
}

// ---- in a sandbox

std::unique_ptr<VolumeSource> open_requested(const std::string& request, const Notice& notice,
                                             const HeaderIsKnown& header_is_known) {
  fs::path path;
  Use use = Use::kSlabs;
  VolumeFileOptions options;
  if (!unpack_all(request, path, use, options.raw, options.choice, options.placement)) {
    throw VolumeFileError("The request to read a volume is damaged.");
  }
  try {
    return open_path(path, {options, use, notice, header_is_known});
  } catch (const fs::filesystem_error& problem) {
    fail_reading(path, problem.code().message(), "Check the name and the permissions");
  }
}

const SandboxTask kReadVolume = reading("read volume", open_requested);

std::unique_ptr<VolumeSource> opened_in_sandbox(const fs::path& path,
                                                const VolumeFileOptions& options, Use use) {
  const bool is_remote = is_address(path.string());
  const SandboxRules rules = {
      .readable = readable_files(split_inner_path(path).first, options.choice.allow_external_files),
      .network = is_remote};
  try {
    return sandboxed_volume(
        path, kReadVolume, rules,
        packed_values(path, use, options.raw, options.choice, options.placement), options.notice);
  } catch (const SandboxError& problem) {
    fail_reading(path, problem.what(), "Check the limits of processes and memory");
  }
}

}  // namespace

Volume read_volume(const fs::path& path, const VolumeFileOptions& options) {
  const std::unique_ptr<VolumeSource> source = opened_in_sandbox(path, options, Use::kWhole);
  const VolumeHeader& header = source->header();
  Volume volume{.dims = header.dims,
                .spacing = header.spacing,
                .index_to_world = header.index_to_world,
                .meaning = header.meaning,
                .samples = source->take_all()};
  volume.meaning.rounding = source->rounding();
  return volume;
}

std::unique_ptr<VolumeSource> open_volume(const fs::path& path, const VolumeFileOptions& options) {
  return opened_in_sandbox(path, options, Use::kSlabs);
}

std::unique_ptr<VolumeSource> volume_of_slices(const std::string& name, StoredVolume slices,
                                               const VolumeFileOptions& options) {
  slices.header.intercept -= options.choice.subtract;
  check_header(name, slices.header);
  check_right_angles(name, slices.header);
  return streamed_volume(name, std::move(slices), {}, allowed_loss(options.choice), options.notice);
}

}  // namespace multitetra
