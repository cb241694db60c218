#include "server/volume/formats/vtk/legacy_vtk_file.hpp"

#include "common/base/number_text.hpp"
#include "server/volume/formats/detail/plain_slices.hpp"
#include "server/volume/formats/detail/text_slices.hpp"
#include "server/volume/formats/vtk/detail/array_choice.hpp"
#include "server/volume/formats/vtk/detail/legacy_vtk_header.hpp"

namespace multitetra {

StoredVolume open_legacy_vtk(const std::filesystem::path& path, const VolumeChoice& choice) {
  const LegacyVtkHeader vtk = parse_legacy_vtk(InputFile(path));
  const VtiArray array = chosen_array(path, vtk.arrays, {}, choice.array);
  StoredVolume volume{.header = {.dims = array.of_cells ? vtk.cells() : vtk.points,
                                 .type = array.type,
                                 .values = kNumbersAsStored,
                                 .components = array.components},
                      .notices = choice_notices(path, vtk.arrays, array, choice.array),
                      .contents = contents_beside(vtk.arrays, array)};
  ImageHeader& header = volume.header;
  StatedNumbers origin = vtk.origin ? stated(*vtk.origin) : kNotStated;
  for (std::size_t axis = 0; axis < 3 && array.of_cells && vtk.origin; ++axis) {
    origin[axis] = (*vtk.origin)[axis] + vtk.spacing.value_or(Vec3{1, 1, 1})[axis] / 2;
  }
  header.slope = array.slope;
  set_box_axes(header, origin, vtk.spacing ? stated(*vtk.spacing) : kNotStated);
  check_header(path, header);
  if (!vtk.unread.empty()) {
    volume.notices.push_back("'" + path.string() + "': what follows from '" + vtk.unread +
                             "' on, behind " + counted(vtk.arrays.size(), "array") +
                             ", is not read.");
  }
  volume.contents.times.at = vtk.times;
  volume.slices = vtk.is_text ? text_slices({.file = path, .begin = array.begin}, header)
                              : plain_slices(path, array.begin, Endian::kBig, header);
  return volume;
}

}  // namespace multitetra
