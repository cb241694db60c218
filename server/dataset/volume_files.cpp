#include "server/dataset/volume_files.hpp"

#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <fstream>
#include <limits>
#include <new>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "server/dataset/dataset.hpp"
#include "server/dataset/image_file.hpp"
#include "server/dataset/image_stack.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;
using Notice = std::function<void(const std::string&)>;

std::string to_text(const std::array<std::int64_t, 3>& dims) {
  return std::to_string(dims[0]) + " x " + std::to_string(dims[1]) + " x " +
         std::to_string(dims[2]);
}

// Throws unless the grid can hold `dims` and the machine their samples: checked before memory is
// asked for, because a damaged header may promise anything.
void check_size(const fs::path& file, const std::array<std::int64_t, 3>& dims,
                std::size_t bytes_per_sample) {
  constexpr std::int64_t kMaxSide = (std::int64_t{1} << kMaxGridExponent) + 1;
  for (const std::int64_t side : dims) {
    if (side < 1 || side > kMaxSide) {
      fail_reading(file, "it has " + to_text(dims) + " samples",
                   "Each side must have 1 to " + std::to_string(kMaxSide) + " samples");
    }
  }
  const std::int64_t bytes =
      dims[0] * dims[1] * dims[2] * static_cast<std::int64_t>(bytes_per_sample);
  const std::int64_t memory = std::int64_t{sysconf(_SC_PHYS_PAGES)} * sysconf(_SC_PAGESIZE);
  if (bytes > memory) {
    fail_reading(file,
                 "its " + to_text(dims) + " samples need " + std::to_string(bytes) +
                     " bytes of memory and this machine has " + std::to_string(memory),
                 "Reduce the volume or use a larger machine");
  }
}

// ---- samples

// Fills memory with all samples of a volume, in the type they have in the file.
using Fill = std::function<void(void*)>;

// Infinity is no place on a surface's way: such samples become void.
void make_infinite_void(const fs::path& file, std::vector<float>& samples, const Notice& notice) {
  std::size_t infinite = 0;
  for (float& sample : samples) {
    if (!std::isinf(sample)) continue;
    sample = std::numeric_limits<float>::quiet_NaN();
    ++infinite;
  }
  if (infinite > 0 && notice) {
    notice("'" + file.string() + "': " + std::to_string(infinite) +
           " samples that are infinite or too large for f32 are void from here on.");
  }
}

// For types that Samples holds.
template <typename Stored>
Samples filled(const fs::path& file, std::size_t count, const Fill& fill, const Notice& notice) {
  std::vector<Stored> samples(count);
  fill(samples.data());
  if constexpr (std::is_floating_point_v<Stored>) make_infinite_void(file, samples, notice);
  return samples;
}

// For types that it does not hold.
template <typename Stored>
Samples converted(const fs::path& file, std::size_t count, const Fill& fill, std::string_view type,
                  const Notice& notice) {
  std::vector<Stored> stored(count);
  fill(stored.data());
  if (notice) {
    notice("'" + file.string() + "': samples of type " + std::string(type) +
           " become f32, with 24 significant bits.");
  }
  std::vector<float> samples(count);
  std::transform(stored.begin(), stored.end(), samples.begin(),
                 [](Stored value) { return static_cast<float>(value); });
  make_infinite_void(file, samples, notice);
  return samples;
}

Samples read_samples(const fs::path& file, StoredType type, std::size_t count, const Fill& fill,
                     const Notice& notice) {
  switch (type) {
    case StoredType::kU8:
      return filled<std::uint8_t>(file, count, fill, notice);
    case StoredType::kI8:
      return filled<std::int8_t>(file, count, fill, notice);
    case StoredType::kU16:
      return filled<std::uint16_t>(file, count, fill, notice);
    case StoredType::kI16:
      return filled<std::int16_t>(file, count, fill, notice);
    case StoredType::kF32:
      return filled<float>(file, count, fill, notice);
    case StoredType::kU32:
      return converted<std::uint32_t>(file, count, fill, "u32", notice);
    case StoredType::kI32:
      return converted<std::int32_t>(file, count, fill, "i32", notice);
    case StoredType::kU64:
      return converted<std::uint64_t>(file, count, fill, "u64", notice);
    case StoredType::kI64:
      return converted<std::int64_t>(file, count, fill, "i64", notice);
    case StoredType::kF64:
      return converted<double>(file, count, fill, "f64", notice);
  }
  return {};
}

Volume volume_of(const fs::path& file, const ImageHeader& header, const Fill& fill,
                 const Notice& notice) {
  check_size(file, header.dims, bytes_of(header.type));
  Volume volume;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    volume.dims[axis] = static_cast<std::int32_t>(header.dims[axis]);
  }
  volume.spacing = header.spacing;
  volume.index_to_world = header.index_to_world;
  volume.samples = read_samples(file, header.type, volume.size(), fill, notice);
  return volume;
}

// ---- one file, many files, raw bytes

Volume read_image(const fs::path& path, const Notice& notice) {
  const ImageFile file(path);
  return volume_of(
      path, file.header(), [&](void* memory) { file.read(memory); }, notice);
}

std::string to_text(const ImageHeader& image) {
  return to_text(image.dims) + " samples of " + std::to_string(bytes_of(image.type)) + " bytes";
}

Volume read_stack(const fs::path& path, const Notice& notice) {
  const std::vector<fs::path> files = stack_files(path);
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
  const auto fill = [&](void* memory) {
    const auto image_bytes =
        static_cast<std::size_t>(first.dims[0] * first.dims[1]) * bytes_of(first.type);
    auto* slice = static_cast<std::byte*>(memory);
    for (const fs::path& name : files) {
      const ImageFile file(name);
      if (file.header().dims != first.dims || file.header().type != first.type) {
        fail_reading(name,
                     "it has " + to_text(file.header()) + " and the first image of the stack, '" +
                         files.front().string() + "', has " + to_text(first),
                     "All images of a stack must have the same size and type");
      }
      file.read(slice);
      slice += image_bytes;
    }
  };
  return volume_of(path, stack, fill, notice);
}

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

Volume read_raw(const fs::path& file, const RawLayout& layout, const Notice& notice) {
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
  const std::size_t width = bytes_of(header.type);
  check_size(file, header.dims, width);
  const auto samples = static_cast<std::size_t>(header.dims[0] * header.dims[1] * header.dims[2]);
  check_raw_size(file, layout, samples * width);

  const auto fill = [&](void* memory) {
    std::ifstream in(file, std::ios::binary);
    in.seekg(static_cast<std::streamoff>(layout.header_bytes));
    in.read(static_cast<char*>(memory), static_cast<std::streamsize>(samples * width));
    if (!in) fail_reading(file, "it cannot be read to its end", "Check its permissions and disk");
    constexpr bool kHostIsLittle = std::endian::native == std::endian::little;
    if (width == 1 || (layout.endian == Endian::kLittle) == kHostIsLittle) return;
    auto* const bytes = static_cast<std::byte*>(memory);
    for (std::size_t i = 0; i < samples; ++i) {
      std::reverse(bytes + i * width, bytes + (i + 1) * width);
    }
  };
  return volume_of(file, header, fill, notice);
}

}  // namespace

Volume read_volume(const fs::path& path, const VolumeFileOptions& options) {
  try {
    const bool exists = fs::exists(path);
    const bool is_stack =
        fs::is_directory(path) || (!exists && is_stack_pattern(path.filename().string()));
    if (is_stack && !options.raw) return read_stack(path, options.notice);
    if (!exists) fail_reading(path, "there is no such file", "Check the name");
    if (!fs::is_regular_file(path)) fail_reading(path, "it is no regular file", "Check the name");
    if (options.raw) return read_raw(path, *options.raw, options.notice);
    return read_image(path, options.notice);
  } catch (const fs::filesystem_error& problem) {
    fail_reading(path, problem.code().message(), "Check the name and the permissions");
  } catch (const std::bad_alloc&) {
    fail_reading(path, "there is not enough memory for its samples",
                 "Reduce the volume or use a larger machine");
  }
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
