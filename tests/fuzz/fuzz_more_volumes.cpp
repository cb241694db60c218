// Whole files in further formats: NumPy, MGH, NetCDF, parallel VTK images, Zarr in zip archives,
// TIFF, PNG, JPEG and Imaris, the contour levels stored with maps, and ParaView collections. The
// first byte selects the format. A file is rejected with a reason or is a volume whose slices can
// be read in any order.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <hdf5.h>

#include "server/volume/formats/detail/contour_level.hpp"
#include "server/volume/formats/hdf5/hdf5_file.hpp"
#include "server/volume/formats/jpeg_file.hpp"
#include "server/volume/formats/mgh_file.hpp"
#include "server/volume/formats/netcdf_file.hpp"
#include "server/volume/formats/npy_file.hpp"
#include "server/volume/formats/png_file.hpp"
#include "server/volume/formats/tiff_file.hpp"
#include "server/volume/formats/vtk/pvd_file.hpp"
#include "server/volume/formats/vtk/pvti_file.hpp"
#include "server/volume/formats/zarr/zarr_volume.hpp"
#include "tests/fuzz/require.hpp"
#include "tests/fuzz/volume_input.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

// Removes and returns the part up to the next zero byte, which is removed too.
std::string_view taken_part(std::string_view& rest) {
  const std::string_view part = rest.substr(0, rest.find('\0'));
  rest.remove_prefix(std::min(part.size() + 1, rest.size()));
  return part;
}

// Attributes of Imaris are texts, stored as arrays of characters.
void add_attribute(hid_t object, const std::string& name, std::string_view text) {
  const auto length = static_cast<hsize_t>(text.size());
  const hid_t space = H5Screate_simple(1, &length, nullptr);
  const hid_t attribute =
      H5Acreate2(object, name.c_str(), H5T_C_S1, space, H5P_DEFAULT, H5P_DEFAULT);
  if (length > 0) H5Awrite(attribute, H5T_C_S1, text.data());
  H5Aclose(attribute);
  H5Sclose(space);
}

// Writes an Imaris file of 4 x 3 x 2 samples whose attributes are the parts of `rest`.
std::filesystem::path imaris_file(std::string_view rest, const TemporaryFolder& folder) {
  const std::filesystem::path path = folder.path() / "v.ims";
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t links = H5Pcreate(H5P_LINK_CREATE);
  H5Pset_create_intermediate_group(links, 1);
  const auto group = [&](const char* name) {
    return H5Gcreate2(file, name, links, H5P_DEFAULT, H5P_DEFAULT);
  };
  const hid_t channel = group("/DataSet/ResolutionLevel 0/TimePoint 0/Channel 0");
  const hid_t image = group("/DataSetInfo/Image");
  const hsize_t dims[] = {2, 3, 4};
  const hid_t space = H5Screate_simple(3, dims, nullptr);
  const hid_t data =
      H5Dcreate2(channel, "Data", H5T_NATIVE_UINT8, space, links, H5P_DEFAULT, H5P_DEFAULT);
  for (const char axis : {'X', 'Y', 'Z'}) {
    add_attribute(channel, std::string("ImageSize") + axis, taken_part(rest));
  }
  for (const char* const name :
       {"ExtMin0", "ExtMin1", "ExtMin2", "ExtMax0", "ExtMax1", "ExtMax2", "Unit"}) {
    add_attribute(image, name, taken_part(rest));
  }
  H5Dclose(data);
  H5Sclose(space);
  H5Gclose(image);
  H5Gclose(channel);
  H5Pclose(links);
  H5Fclose(file);
  return path;
}

void require_finite(const std::optional<double>& level) {
  require(!level || std::isfinite(*level));
}

std::optional<StoredVolume> opened_further(int format, std::string_view bytes,
                                           const TemporaryFolder& folder) {
  const VolumeChoice choice{.first = true};
  switch (format) {
    case 0:
      return open_npy(folder.file("v.npy", bytes), choice);
    case 1:
      return open_mgh(folder.file("v.mgh", bytes), choice);
    case 2:
      return open_mgh(folder.file("v.mgz", gzipped(bytes)), choice);
    case 3:
      return open_netcdf(folder.file("v.nc", bytes), choice);
    case 4: {
      const std::string_view whole = taken_part(bytes);
      folder.file("piece.vti", bytes);
      return open_pvti(folder.file("v.pvti", whole), choice);
    }
    case 5:
      return open_zarr(folder.file("v.zip", bytes).string(), choice);
    case 6:
      require_finite(contour_level_in_xml(bytes));
      return std::nullopt;
    case 7:
      require_finite(contour_level_in_json(bytes));
      return std::nullopt;
    case 8:
      return open_tiff(folder.file("v.tif", bytes), choice);
    case 9:
      return open_png(folder.file("v.png", bytes));
    case 10:
      return open_jpeg(folder.file("v.jpg", bytes));
    case 11:
      return open_hdf5(imaris_file(bytes, folder), choice);
    case 12:
      if (const auto entries = parse_pvd(bytes)) require(!entries->empty());
      return std::nullopt;
    default:
      return std::nullopt;
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
    // 16 leaves room for further formats with the existing corpus.
    if (const auto volume = opened_further(data[0] % 16, bytes, folder)) read_in_any_order(*volume);
  } catch (const VolumeFileError& refused) {
    require(std::string_view(refused.what()).starts_with("Cannot read '"));
  }
  return 0;
}
