// Whole files in the formats that we read ourselves: NIfTI, MRC, cubes, XML and legacy VTK images,
// NRRD, MetaImage, and raw samples that a text or their first bytes describe. The first byte says
// which, and whether the file is packed. A file is refused with a reason or is a volume whose
// slices can be read in any order, each the same alone as among all.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <zlib.h>

#include "server/volume/formats/cube_file.hpp"
#include "server/volume/formats/described_raw.hpp"
#include "server/volume/formats/meta_image_file.hpp"
#include "server/volume/formats/mrc_file.hpp"
#include "server/volume/formats/nifti_file.hpp"
#include "server/volume/formats/nrrd_file.hpp"
#include "server/volume/formats/vtk/legacy_vtk_file.hpp"
#include "server/volume/formats/vtk/vti_file.hpp"
#include "tests/fuzz/require.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

constexpr std::int64_t kMostBytes = 1 << 20;  // Larger volumes only cost time here.

std::string gzipped(std::string_view bytes) {
  z_stream stream{};
  require(deflateInit2(&stream, 1, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY) == Z_OK);
  std::string packed(deflateBound(&stream, bytes.size()) + 32, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  require(deflate(&stream, Z_FINISH) == Z_STREAM_END);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

// nullopt: nothing describes the raw samples.
std::optional<StoredVolume> opened(int format, std::string_view bytes,
                                   const TemporaryFolder& folder) {
  // Where there are several, the first: what is inside matters, not that one must choose.
  const VolumeChoice choice{.first = true};
  switch (format) {
    case 0:
      return open_nifti(folder.file("v.nii", bytes), choice);
    case 1:
      return open_nifti(folder.file("v.nii.gz", gzipped(bytes)), choice);
    case 2:
      return open_mrc(folder.file("v.mrc", bytes));
    case 3:
      return open_mrc(folder.file("v.map.gz", gzipped(bytes)));
    case 4:
      return open_cube(folder.file("v.cube", bytes));
    case 5:
      return open_vti(folder.file("v.vti", bytes), choice);
    case 6: {  // The description; the samples are 64 zeros.
      folder.file("v.raw", std::string(64, '\0'));
      return open_described(described_raw(folder.file("v.dat", bytes), /*follow=*/false));
    }
    case 8:
      return open_nrrd(folder.file("v.nrrd", bytes), choice);
    case 9:
      return open_meta_image(folder.file("v.mha", bytes), choice);
    case 10:
      return open_legacy_vtk(folder.file("v.vtk", bytes));
    default: {
      const auto raw = layout_of_raw(folder.file("counted.raw", bytes));
      if (!raw) return std::nullopt;
      return open_described(*raw);
    }
  }
}

void read(const StoredVolume& volume) {
  const ImageHeader& header = volume.header;
  check_header("fuzzed", header);
  const std::size_t slice = header.slice_bytes();
  if (slice > kMostBytes || header.dims[2] > kMostBytes / static_cast<std::int64_t>(slice)) return;
  const auto slices = static_cast<std::size_t>(header.dims[2]);
  std::vector<std::byte> all(slices * slice);
  volume.slices->read(0, slices, all.data());
  std::vector<std::byte> one(slice);
  for (std::size_t i = std::min<std::size_t>(slices, 8); i-- > 0;) {
    volume.slices->read(i, 1, one.data());
    require(std::equal(one.begin(), one.end(), all.data() + i * slice));
  }
}

}  // namespace
}  // namespace multitetra

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multitetra;
  static const TemporaryFolder folder;
  if (size == 0) return 0;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  try {
    if (const auto volume = opened(data[0] % 11, bytes, folder)) read(*volume);
  } catch (const VolumeFileError& refused) {
    require(std::string_view(refused.what()).starts_with("Cannot read '"));
  }
  return 0;
}
