#include "server/dataset/volume_files.hpp"

#include <unistd.h>

#include <cmath>
#include <cstddef>
#include <new>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "server/dataset/dataset.hpp"
#include "server/dataset/image_file.hpp"
#include "server/dataset/image_stack.hpp"
#include "server/dataset/plain_payload.hpp"
#include "server/dataset/sample_conversion.hpp"
#include "server/dataset/streamed_volume.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

std::string to_text(const std::array<std::int64_t, 3>& dims) {
  return std::to_string(dims[0]) + " x " + std::to_string(dims[1]) + " x " +
         std::to_string(dims[2]);
}

// What a volume is opened for: slab by slab, or to be in memory as a whole.
enum class Use { kSlabs, kWhole };

// Throws unless the grid can hold `dims`: checked first, because a damaged header may promise
// anything.
void check_sides(const fs::path& file, const std::array<std::int64_t, 3>& dims) {
  constexpr std::int64_t kMaxSide = (std::int64_t{1} << kMaxGridExponent) + 1;
  for (const std::int64_t side : dims) {
    if (side < 1 || side > kMaxSide) {
      fail_reading(file, "it has " + to_text(dims) + " samples",
                   "Each side must have 1 to " + std::to_string(kMaxSide) + " samples");
    }
  }
}

// Throws unless the machine can hold all samples: checked before memory is asked for.
void check_memory(const fs::path& file, const ImageHeader& header) {
  const std::int64_t bytes = header.dims[0] * header.dims[1] * header.dims[2] *
                             static_cast<std::int64_t>(bytes_of(header.type));
  const std::int64_t memory = std::int64_t{sysconf(_SC_PHYS_PAGES)} * sysconf(_SC_PAGESIZE);
  if (bytes > memory) {
    fail_reading(file,
                 "its " + to_text(header.dims) + " samples need " + std::to_string(bytes) +
                     " bytes of memory and this machine has " + std::to_string(memory),
                 "Reduce the volume or use a larger machine");
  }
}

// ---- one file

Volume read_whole(const fs::path& path, const ImageFile& file, const Notice& notice) {
  const ImageHeader& image = file.header();
  const VolumeHeader header = volume_header(image);
  Volume volume = {.dims = header.dims,
                   .spacing = header.spacing,
                   .index_to_world = header.index_to_world,
                   .samples = {}};
  resize(volume.samples, header.type, volume.size());
  if (is_converted(image.type)) {
    std::vector<std::byte> stored(volume.size() * bytes_of(image.type));
    file.read(stored.data());
    tell_conversion(notice, path, image.type);
    convert(image.type, stored.data(), std::get<std::vector<float>>(volume.samples));
  } else {
    file.read(bytes_of(volume.samples));
  }
  if (auto* const floats = std::get_if<std::vector<float>>(&volume.samples)) {
    tell_infinite(notice, path, make_infinite_void(*floats));
  }
  return volume;
}

std::unique_ptr<VolumeSource> open_image(const fs::path& path, const Notice& notice, Use use) {
  const ImageFile file(path);
  check_sides(path, file.header().dims);
  const std::optional<PlainPayload> payload = file.plain_payload();
  if (!payload || use == Use::kWhole) check_memory(path, file.header());
  if (!payload) return source_of(read_whole(path, file, notice));
  return streamed_volume(path, file.header(), slices_of(*payload, file.header()), notice);
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
    const auto image_bytes =
        static_cast<std::size_t>(first_.dims[0] * first_.dims[1]) * bytes_of(first_.type);
    for (std::size_t i = 0; i < count; ++i) read_image(files_[first + i], into + i * image_bytes);
  }

 private:
  void read_image(const fs::path& name, std::byte* into) const {
    const ImageFile file(name);
    if (file.header().dims != first_.dims || file.header().type != first_.type) {
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

std::unique_ptr<VolumeSource> open_stack(const fs::path& path, const Notice& notice, Use use) {
  std::vector<fs::path> files = stack_files(path);
  if (files.empty()) {
    fail_reading(path, "there are no TIFF images in this directory or of this pattern",
                 "Give a directory with .tif or .tiff files, or a pattern such as slice%03d.tif");
  }
  const ImageHeader first = ImageFile(files.front()).header();
  if (first.dims[2] != 1) {
    fail_reading(files.front(), "it holds " + std::to_string(first.dims[2]) + " images",
                 "A stack is made of files with one image each; give this file alone");
  }
  ImageHeader stack = first;
  stack.dims[2] = static_cast<std::int64_t>(files.size());
  check_sides(path, stack.dims);
  if (use == Use::kWhole) check_memory(path, stack);
  return streamed_volume(path, stack, std::make_unique<StackSlices>(std::move(files), first),
                         notice);
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
  header.type = static_cast<StoredType>(layout.type);
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

std::unique_ptr<VolumeSource> open_raw(const fs::path& file, const RawLayout& layout,
                                       const Notice& notice, Use use) {
  const ImageHeader header = header_of(file, layout);
  check_sides(file, header.dims);
  if (use == Use::kWhole) check_memory(file, header);
  const std::uint64_t sample_bytes =
      static_cast<std::uint64_t>(header.dims[0] * header.dims[1] * header.dims[2]) *
      bytes_of(header.type);
  check_raw_size(file, layout, sample_bytes);
  PlainPayload payload{{{file, layout.header_bytes}}, sample_bytes, layout.endian};
  return streamed_volume(file, header, slices_of(std::move(payload), header), notice);
}

// ---- whatever the path names

std::unique_ptr<VolumeSource> open_path(const fs::path& path, const VolumeFileOptions& options,
                                        Use use) {
  const bool exists = fs::exists(path);
  const bool is_stack =
      fs::is_directory(path) || (!exists && is_stack_pattern(path.filename().string()));
  if (is_stack && !options.raw) return open_stack(path, options.notice, use);
  if (!exists) fail_reading(path, "there is no such file", "Check the name");
  if (!fs::is_regular_file(path)) fail_reading(path, "it is no regular file", "Check the name");
  if (options.raw) return open_raw(path, *options.raw, options.notice, use);
  return open_image(path, options.notice, use);
}

// Runs `read`, which reads from `path`, and tells what went wrong around the files in our words.
template <typename Read>
auto reading(const fs::path& path, const Read& read) {
  try {
    return read();
  } catch (const fs::filesystem_error& problem) {
    fail_reading(path, problem.code().message(), "Check the name and the permissions");
  } catch (const std::bad_alloc&) {
    fail_reading(path, "there is not enough memory for its samples",
                 "Reduce the volume or use a larger machine");
  }
}

}  // namespace

Volume read_volume(const fs::path& path, const VolumeFileOptions& options) {
  return reading(path, [&] {
    const std::unique_ptr<VolumeSource> source = open_path(path, options, Use::kWhole);
    const VolumeHeader& header = source->header();
    return Volume{.dims = header.dims,
                  .spacing = header.spacing,
                  .index_to_world = header.index_to_world,
                  .samples = source->take_all()};
  });
}

std::unique_ptr<VolumeSource> open_volume(const fs::path& path, const VolumeFileOptions& options) {
  return reading(path, [&] { return open_path(path, options, Use::kSlabs); });
}

void write_nrrd(const fs::path& path, const Volume& volume) {
  if (path.extension() != ".nrrd") {
    throw VolumeFileError("Cannot write '" + path.string() + "': its name must end in .nrrd.");
  }
  const fs::path temporary =
      path.parent_path() / ("." + path.stem().string() + "." + std::to_string(getpid()) + ".nrrd");
  std::error_code error;
  try {
    write_nrrd_image(temporary, volume);
    fs::rename(temporary, path);
  } catch (const VolumeFileError&) {
    fs::remove(temporary, error);
    throw;
  } catch (const fs::filesystem_error& problem) {
    fs::remove(temporary, error);
    throw VolumeFileError("Cannot write '" + path.string() + "': " + problem.code().message() +
                          ". Check the folder and its permissions.");
  }
}

}  // namespace multitetra
