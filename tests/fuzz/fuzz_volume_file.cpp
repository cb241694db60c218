// Whole files in the formats that we parse ourselves: NIfTI, MRC, cubes, XML and legacy VTK images,
// NRRD, MetaImage, and raw samples described by a text or their first bytes. The first byte selects
// the format, and whether the file is compressed. A file is rejected with a reason or is a volume
// whose slices can be read in any order, with the same result alone as together.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "server/volume/formats/cube_file.hpp"
#include "server/volume/formats/described_raw.hpp"
#include "server/volume/formats/meta_image_file.hpp"
#include "server/volume/formats/mrc_file.hpp"
#include "server/volume/formats/nifti_file.hpp"
#include "server/volume/formats/nrrd_file.hpp"
#include "server/volume/formats/vtk/legacy_vtk_file.hpp"
#include "server/volume/formats/vtk/vti_file.hpp"
#include "tests/fuzz/require.hpp"
#include "tests/fuzz/volume_input.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

// Returns nullopt if nothing describes the raw samples.
std::optional<StoredVolume> opened(int format, std::string_view bytes,
                                   const TemporaryFolder& folder) {
  // Selects the first of several volumes: the test is about contents, not the choice.
  const VolumeChoice choice{.first = true};
  switch (format) {
    case 0:
      return open_nifti(folder.file("v.nii", bytes), choice);
    case 1:
      return open_nifti(folder.file("v.nii.gz", gzipped(bytes)), choice);
    case 2:
      return open_mrc(folder.file("v.mrc", bytes), choice);
    case 3:
      return open_mrc(folder.file("v.map.gz", gzipped(bytes)), choice);
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
      return open_legacy_vtk(folder.file("v.vtk", bytes), choice);
    default: {
      const auto raw = layout_of_raw(folder.file("counted.raw", bytes));
      if (!raw) return std::nullopt;
      return open_described(*raw);
    }
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
    if (const auto volume = opened(data[0] % 11, bytes, folder)) read_in_any_order(*volume);
  } catch (const VolumeFileError& refused) {
    require(std::string_view(refused.what()).starts_with("Cannot read '"));
  }
  return 0;
}
