#include "server/dataset/volume_files.hpp"

#include <unistd.h>

#include <cmath>
#include <cstddef>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/address_text.hpp"
#include "common/base/child_process.hpp"
#include "server/dataset/formats/cube_file.hpp"
#include "server/dataset/formats/described_raw.hpp"
#include "server/dataset/formats/dicom_series.hpp"
#include "server/dataset/formats/hdf5_file.hpp"
#include "server/dataset/formats/input_file.hpp"
#include "server/dataset/formats/mgh_file.hpp"
#include "server/dataset/formats/mrc_file.hpp"
#include "server/dataset/formats/netcdf3_file.hpp"
#include "server/dataset/formats/nifti_file.hpp"
#include "server/dataset/formats/npy_file.hpp"
#include "server/dataset/formats/plain_slices.hpp"
#include "server/dataset/formats/pvti_file.hpp"
#include "server/dataset/formats/recognition.hpp"
#include "server/dataset/formats/unpacking.hpp"
#include "server/dataset/formats/volume_objects.hpp"
#include "server/dataset/formats/vti_file.hpp"
#include "server/dataset/formats/zarr_volume.hpp"
#include "server/dataset/image_file.hpp"
#include "server/dataset/image_stack.hpp"
#include "server/dataset/plain_payload.hpp"
#include "server/dataset/section_table.hpp"
#include "server/dataset/source_apart.hpp"
#include "server/dataset/streamed_volume.hpp"
#include "server/store/http_store.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

std::string to_text(const std::array<std::int64_t, 3>& dims) {
  return std::to_string(dims[0]) + " x " + std::to_string(dims[1]) + " x " +
         std::to_string(dims[2]);
}

// What a volume is opened for: slab by slab, or to be in memory as a whole.
enum class Use { kSlabs, kWhole };

// Throws unless the machine can hold all samples: checked before memory is asked for.
void check_memory(const fs::path& file, const ImageHeader& header) {
  const std::int64_t bytes = header.dims[2] * static_cast<std::int64_t>(header.slice_bytes());
  const std::int64_t memory = std::int64_t{sysconf(_SC_PHYS_PAGES)} * sysconf(_SC_PAGESIZE);
  if (bytes > memory) {
    fail_reading(file,
                 "its " + to_text(header.dims) + " samples need " + std::to_string(bytes) +
                     " bytes of memory and this machine has " + std::to_string(memory),
                 "Reduce the volume or use a larger machine");
  }
}

// Of the samples, where they are held as a whole: as stored, and converted to at most 4 bytes each.
std::uint64_t held_bytes(const ImageHeader& header, bool as_a_whole) {
  const auto samples = static_cast<std::uint64_t>(header.dims[0] * header.dims[1] * header.dims[2]);
  const std::uint64_t stored = header.slice_bytes() * static_cast<std::uint64_t>(header.dims[2]);
  return as_a_whole ? stored + 4 * samples : 0;
}

// How a volume is opened: what for, and whom to tell.
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

// ---- one file through ITK

// The samples of a file that ITK reads as a whole.
class SlicesInMemory : public StoredSlices {
 public:
  SlicesInMemory(const ImageFile& file, const ImageHeader& header)
      : slice_bytes_(header.slice_bytes()),
        bytes_(slice_bytes_ * static_cast<std::size_t>(header.dims[2])) {
    file.read(bytes_.data());
  }

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    std::memcpy(into, bytes_.data() + first * slice_bytes_, count * slice_bytes_);
  }

 private:
  std::size_t slice_bytes_;
  std::vector<std::byte> bytes_;
};

// Slices that are all in memory already.
class WholeVolume : public VolumeSource {
 public:
  explicit WholeVolume(std::unique_ptr<VolumeSource> source) : source_(std::move(source)) {}
  [[nodiscard]] const VolumeHeader& header() const override { return source_->header(); }
  void read(std::int32_t first_slice, std::int32_t slices, Samples& into) override {
    source_->read(first_slice, slices, into);
  }
  [[nodiscard]] const SourceMembers& members() const override { return source_->members(); }
  [[nodiscard]] bool streams() const override { return false; }

 private:
  std::unique_ptr<VolumeSource> source_;
};

std::unique_ptr<VolumeSource> open_image(const fs::path& path, VolumeFormat format,
                                         const Opening& opening) {
  const VolumeChoice& choice = opening.options.choice;
  const ImageFile file(path, format, choice);
  const ImageHeader header = file.header();
  check_header(path, header);
  const std::optional<PlainPayload> payload = file.plain_payload();
  opening.header_is_known(held_bytes(header, !payload || opening.use == Use::kWhole));
  if (!payload || opening.use == Use::kWhole) check_memory(path, header);
  ComponentChoice component = component_of(choice);
  if (const auto time = file.component_of_time()) {
    component = {.kind = ComponentChoice::Kind::kIndex, .index = *time};
  }
  auto slices =
      payload ? slices_of(*payload, header) : std::make_unique<SlicesInMemory>(file, header);
  auto source = streamed_volume(
      path, {.header = header, .slices = std::move(slices), .members = file.members()}, component,
      opening.notice);
  if (payload) return source;
  return std::make_unique<WholeVolume>(std::move(source));
}

// ---- a file for each slice

std::string to_text(const ImageHeader& image) {
  return to_text(image.dims) + " samples of " + std::to_string(bytes_of(image.type)) + " bytes";
}

// Images of one slice each, opened when they are read.
class StackSlices : public StoredSlices {
 public:
  StackSlices(std::vector<fs::path> files, const ImageHeader& first)
      : files_(std::move(files)), first_(first) {}

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    for (std::size_t i = 0; i < count; ++i) {
      read_image(files_[first + i], into + i * first_.slice_bytes());
    }
  }

 private:
  void read_image(const fs::path& name, std::byte* into) const {
    const ImageFile file(name, VolumeFormat::kTiff);
    if (file.header().dims != first_.dims || file.header().type != first_.type ||
        file.header().components != first_.components) {
      fail_reading(name,
                   "it has " + to_text(file.header()) + " and the first image of the stack, '" +
                       files_.front().string() + "', has " + to_text(first_),
                   "All images of a stack must have the same size and type");
    }
    file.read(into);
  }

  std::vector<fs::path> files_;
  ImageHeader first_;
};

StoredVolume open_stack(const fs::path& path) {
  std::vector<fs::path> files = stack_files(path);
  if (files.empty()) {
    fail_reading(path, "there are no TIFF images in this directory or of this pattern",
                 "Give a directory with .tif or .tiff files, or a pattern such as slice%03d.tif");
  }
  const ImageHeader first = ImageFile(files.front(), VolumeFormat::kTiff).header();
  if (first.dims[2] != 1) {
    fail_reading(files.front(), "it holds " + std::to_string(first.dims[2]) + " images",
                 "A stack is made of files with one image each; give this file alone");
  }
  ImageHeader stack = first;
  stack.dims[2] = static_cast<std::int64_t>(files.size());
  check_header(path, stack);
  return {.header = stack, .slices = std::make_unique<StackSlices>(std::move(files), first)};
}

// ---- raw bytes

// Throws unless the file has exactly the bytes that the layout needs.
void check_raw_size(const fs::path& file, const RawLayout& layout, std::uint64_t sample_bytes) {
  const std::uint64_t found = fs::file_size(file);
  if (found >= layout.header_bytes && found - layout.header_bytes == sample_bytes) return;
  fail_reading(file,
               "it has " + std::to_string(found) + " bytes, and the given layout needs " +
                   std::to_string(layout.header_bytes) + " of header and " +
                   std::to_string(sample_bytes) + " of samples (" + std::to_string(layout.dims[0]) +
                   " x " + std::to_string(layout.dims[1]) + " x " + std::to_string(layout.dims[2]) +
                   " of type " + std::string(name(layout.type)) + ")",
               "Correct the dims, the type or the header bytes");
}

ImageHeader header_of(const fs::path& file, const RawLayout& layout) {
  ImageHeader header;
  header.type = layout.type;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(layout.spacing[axis]) || layout.spacing[axis] <= 0) {
      fail_reading(file, "the given spacing " + std::to_string(layout.spacing[axis]) + " is none",
                   "Spacings are numbers greater than 0");
    }
    header.dims[axis] = layout.dims[axis];
    header.spacing[axis] = layout.spacing[axis];
    header.index_to_world.columns[axis][axis] = layout.spacing[axis];
  }
  return header;
}

StoredVolume open_raw(const fs::path& file, const RawLayout& layout) {
  const ImageHeader header = header_of(file, layout);
  check_header(file, header);
  const std::uint64_t sample_bytes =
      header.slice_bytes() * static_cast<std::uint64_t>(header.dims[2]);
  const Packing packing = UnpackedStream::packing_at(InputFile(file), 0);
  const bool exact = fs::file_size(file) == layout.header_bytes + sample_bytes;
  if (!exact && (packing == Packing::kGzip || packing == Packing::kBzip2)) {
    return {.header = header,
            .slices = packed_slices(file, 0, layout.header_bytes, layout.endian, header)};
  }
  check_raw_size(file, layout, sample_bytes);
  return {.header = header,
          .slices = plain_slices(file, layout.header_bytes, layout.endian, header)};
}

// ---- whatever the path names

// "file.h5:/path" is a file and a path inside it, unless there is a file of that name.
std::pair<fs::path, std::string> file_and_inside(const fs::path& path) {
  std::error_code error;
  const std::string text = path.string();
  const std::size_t colon = text.rfind(":/");
  if (colon == std::string::npos || colon == 0 || fs::exists(path, error)) return {path, {}};
  return {text.substr(0, colon), text.substr(colon + 1)};
}

StoredVolume open_format(const fs::path& path, VolumeFormat format, const VolumeChoice& choice) {
  switch (format) {
    case VolumeFormat::kNifti:
      return open_nifti(path, choice);
    case VolumeFormat::kTiffStack:
      return open_stack(path);
    case VolumeFormat::kVti:
      return open_vti(path, choice);
    case VolumeFormat::kPvti:
      return open_pvti(path, choice);
    case VolumeFormat::kDicom:
      return open_dicom(path, fs::is_directory(path) ? dicom_files(path) : std::vector{path},
                        choice);
    case VolumeFormat::kZarr:
      return open_zarr(volume_objects(path.string(), choice.follow), choice);
    case VolumeFormat::kHdf5:
      return open_hdf5(path, choice);
    case VolumeFormat::kNetcdf3:
      return open_netcdf3(path, choice);
    case VolumeFormat::kNpy:
      return open_npy(path, choice);
    case VolumeFormat::kMgh:
      return open_mgh(path, choice);
    case VolumeFormat::kMrc:
      return open_mrc(path);
    case VolumeFormat::kCube:
      return open_cube(path);
    case VolumeFormat::kRawDescription:
      return open_described(described_raw(path, choice.follow));
    default:
      break;
  }
  const std::optional<DescribedRaw> raw = layout_of_raw(path);
  if (!raw) fail_reading(path, "nothing tells the layout of its samples", "Give it with --dims");
  StoredVolume volume = open_described(*raw);
  volume.notices.push_back("'" + path.string() + "': the layout is told by " + raw->source + ".");
  return volume;
}

std::string known_files() {
  std::string text;
  for (const FormatDescription& format : known_formats()) {
    text += (text.empty() ? "" : ", ") + std::string(format.name) + " (" +
            std::string(format.files) + ")";
  }
  return text;
}

StoredVolume open_address(const std::string& address, const VolumeChoice& choice) {
  std::shared_ptr<ObjectStore> store = volume_objects(address, choice.follow);
  if (!is_zarr(*store)) {
    fail_reading(address,
                 "there is no zarr.json, .zattrs, .zgroup, .zarray or attributes.json below it",
                 "Give the address of an OME-Zarr image or of a Zarr or N5 array, and the "
                 "credentials that it "
                 "needs");
  }
  return open_zarr(std::move(store), choice);
}

std::unique_ptr<VolumeSource> open_path(const fs::path& whole_path, const Opening& opening) {
  const auto [path, inside] = file_and_inside(whole_path);
  VolumeChoice choice = opening.options.choice;
  if (!inside.empty()) choice.array = inside;
  const auto as_source = [&](StoredVolume stored) {
    opening.header_is_known(held_bytes(stored.header, opening.use == Use::kWhole));
    if (opening.use == Use::kWhole) check_memory(whole_path, stored.header);
    return streamed_volume(without_password(whole_path.string()), std::move(stored),
                           component_of(choice), opening.notice);
  };
  if (is_address(whole_path.string())) {
    return as_source(open_address(whole_path.string(), opening.options.choice));
  }
  if (!fs::exists(path)) {
    if (!is_stack_pattern(path.filename().string()) || opening.options.raw) {
      fail_reading(path, "there is no such file", "Check the name");
    }
    return as_source(open_stack(path));
  }
  if (opening.options.raw) return as_source(open_raw(path, *opening.options.raw));
  const std::optional<VolumeFormat> format = recognized_format(path);
  if (!format && begins_as_dataset(path)) {
    fail_reading(path, "it is no volume, but a dataset already",
                 "Serve it, or prepare the volume that it was made of");
  }
  if (!format) {
    fail_reading(path,
                 fs::is_directory(path)
                     ? "this folder holds neither TIFF nor DICOM images nor a Zarr or N5 array"
                     : "neither its content nor its name is that of a known format",
                 "Known are " + known_files() + "; give the layout of raw samples with --dims");
  }
  switch (*format) {
    case VolumeFormat::kNrrd:
    case VolumeFormat::kMetaImage:
    case VolumeFormat::kLegacyVtk:
    case VolumeFormat::kTiff:
      return open_image(path, *format, opening);
    default:
      return as_source(open_format(path, *format, choice));
  }
}

std::unique_ptr<VolumeSource> opened_apart(const fs::path& path, const VolumeFileOptions& options,
                                           Use use) {
  const auto open = [&](const Notice& notice, const HeaderIsKnown& header_is_known) {
    try {
      return open_path(path, {options, use, notice, header_is_known});
    } catch (const fs::filesystem_error& problem) {
      fail_reading(path, problem.code().message(), "Check the name and the permissions");
    }
  };
  try {
    return open_apart(path, open, options.notice);
  } catch (const ChildProcessError& problem) {
    fail_reading(path, problem.what(), "Try again when the machine has more room");
  }
}

}  // namespace

Volume read_volume(const fs::path& path, const VolumeFileOptions& options) {
  const std::unique_ptr<VolumeSource> source = opened_apart(path, options, Use::kWhole);
  const VolumeHeader& header = source->header();
  return Volume{.dims = header.dims,
                .spacing = header.spacing,
                .index_to_world = header.index_to_world,
                .meaning = header.meaning,
                .samples = source->take_all()};
}

std::unique_ptr<VolumeSource> open_volume(const fs::path& path, const VolumeFileOptions& options) {
  return opened_apart(path, options, Use::kSlabs);
}

}  // namespace multitetra
