#include "server/volume/formats/hdf5/hdf5_file.hpp"

#include <string>
#include <utility>
#include <vector>

#include "server/volume/formats/hdf5/detail/hdf5_container.hpp"
#include "server/volume/formats/hdf5/detail/hdf5_lzf.hpp"
#include "server/volume/formats/netcdf_file.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

// Returns whether the netCDF library wrote the file, which is closed again: libhdf5 opens no file
// twice with different properties.
bool is_netcdf4(const fs::path& path) {
  const Hdf5Id opened = open_hdf5_file(path);
  const Hdf5Container file(path, opened.get(), /*allow_external_files=*/false);
  if (!file.texts("", "_NCProperties").empty() || !file.numbers("", "_nc3_strict").empty())
    return true;
  for (const std::string& name : file.children("")) {
    if (!file.numbers("/" + name, "_Netcdf4Dimid").empty()) return true;
  }
  return false;
}

}  // namespace

bool is_hdf5(std::string_view beginning) {
  for (const std::size_t at : {0u, 512u, 1024u, 2048u}) {  // Other data may precede the signature.
    if (beginning.size() > at && beginning.substr(at).starts_with("\x89HDF\r\n\x1a\n")) return true;
  }
  return false;
}

StoredVolume open_hdf5(const fs::path& path, const VolumeChoice& choice) {
  register_hdf5_lzf();
  if (is_netcdf4(path)) return open_netcdf(path, choice);
  Hdf5Id file = open_hdf5_file(path);
  Hdf5Container container(path, file.get(), choice.allow_external_files);
  container.described_by = choice.described_by;
  const std::string array = chosen_array(container, choice);
  // Refuses links to other files that are not permitted.
  if (!open_hdf5_dataset(path, file.get(), array, choice.allow_external_files)) {
    fail_reading(path, "it has no dataset '" + array + "'", "Check the path inside the file");
  }
  ArrayMeaning meaning = meaning_of(container, array);
  if (choice.level && !meaning.has_levels) {
    fail_reading(path, "--level does not apply: the file has no resolution levels", "Omit --level");
  }
  VolumeInArray place;
  StoredVolume volume = described_volume(container, array, std::move(meaning), choice,
                                         /*has_components=*/true, place);
  if (choice.first) list_arrays(container, array, volume.contents);
  const std::string unwritten =
      unwritten_notice(path, file.get(), array, choice.allow_external_files);
  if (!unwritten.empty()) volume.notices.push_back(unwritten);
  std::vector<std::int64_t> shape = container.shape(array);
  for (std::size_t axis = 0; axis < 3; ++axis) {  // Without padding.
    if (place.axes[axis]) shape[*place.axes[axis]] = volume.header.dims[axis];
  }
  volume.slices =
      array_slices(hdf5_reader(path, std::move(file), array, choice.allow_external_files),
                   std::move(shape), std::move(place));
  return volume;
}

}  // namespace multitetra
