#include "server/volume/generators/written_nrrd.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <locale>
#include <span>
#include <sstream>
#include <system_error>
#include <variant>

#include "common/base/atomic_file.hpp"
#include "server/volume/volume_files.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kSamplesAtOnce = std::size_t{8} << 20;

static_assert(std::endian::native == std::endian::little, "Samples are written as they lie.");

// By SampleType.
constexpr std::array<const char*, 5> kNrrdTypes = {"uint8", "int8", "uint16", "int16", "float"};

void put_vector(std::ostream& out, const Vec3& v) {
  out << '(' << v[0] << ',' << v[1] << ',' << v[2] << ')';
}

std::string nrrd_header(const VolumeHeader& volume) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out.precision(17);
  out << "NRRD0004\ntype: " << kNrrdTypes[static_cast<std::size_t>(volume.type)]
      << "\ndimension: 3\n"
      << "space: left-posterior-superior\nsizes:";
  for (const std::int64_t count : volume.dims) out << ' ' << count;
  out << "\nspace directions:";
  for (const Vec3& step : volume.index_to_world.columns) put_vector(out << ' ', step);
  out << "\nkinds: domain domain domain\nendian: little\nencoding: raw\nspace origin: ";
  put_vector(out, volume.index_to_world.translation);
  out << "\n\n";
  return out.str();
}

}  // namespace

void write_nrrd(const std::filesystem::path& path, VolumeSource& source,
                const std::function<void(std::int32_t slices)>& progress) {
  if (path.extension() != ".nrrd") {
    throw VolumeFileError("Cannot write '" + path.string() + "': its name must end in .nrrd.");
  }
  const VolumeHeader& volume = source.header();
  const auto slab = static_cast<std::int32_t>(
      std::max(kSamplesAtOnce / volume.samples_per_slice(), std::size_t{1}));
  try {
    AtomicFile file(path);
    const std::string header = nrrd_header(volume);
    file.write_at(0, std::as_bytes(std::span(header)));
    std::uint64_t end = header.size();
    Samples samples;
    for (std::int32_t z = 0; z < volume.dims[2]; z += slab) {
      const std::int32_t slices = std::min(slab, volume.dims[2] - z);
      source.read(z, slices, samples);
      std::visit(
          [&](const auto& values) {
            const auto bytes = std::as_bytes(std::span(values));
            file.write_at(end, bytes);
            end += bytes.size();
          },
          samples);
      if (progress) progress(z + slices);
    }
    file.commit(Durability::kProcessEnd);
  } catch (const std::system_error& problem) {
    throw VolumeFileError("Cannot write '" + path.string() + "': " + problem.code().message() +
                          ". Check the folder, its permissions and the free space.");
  }
}

}  // namespace multitetra
