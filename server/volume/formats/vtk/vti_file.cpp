#include "server/volume/formats/vtk/vti_file.hpp"

#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "server/volume/formats/vtk/detail/array_choice.hpp"
#include "server/volume/formats/vtk/vtk_arrays.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

class VtiSlices : public StoredSlices {
 public:
  VtiSlices(std::unique_ptr<const VtkArrays> arrays, std::unique_ptr<SampleBytes> bytes,
            std::size_t slice_bytes)
      : arrays_(std::move(arrays)), bytes_(std::move(bytes)), slice_bytes_(slice_bytes) {}

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    bytes_->read(first * slice_bytes_, {into, count * slice_bytes_});
  }

 private:
  std::unique_ptr<const VtkArrays> arrays_;
  std::unique_ptr<SampleBytes> bytes_;
  std::size_t slice_bytes_;
};

// Returns the time that the field data state; none if it is not a finite float.
std::vector<double> time_of(const VtkArrays& arrays) {
  const std::optional<VtiArray>& array = arrays.header().time;
  if (!array || array->components != 1) return {};
  double time = 0;
  if (array->type == StoredType::kF64) {
    arrays.open(*array, 1)->read(0, std::as_writable_bytes(std::span(&time, 1)));
  } else if (array->type == StoredType::kF32) {
    float single = 0;
    arrays.open(*array, 1)->read(0, std::as_writable_bytes(std::span(&single, 1)));
    time = single;
  } else {
    return {};
  }
  return std::isfinite(time) ? std::vector{time} : std::vector<double>();
}

}  // namespace

VtiPiece open_vti_piece(const fs::path& path, const VolumeChoice& choice) {
  auto arrays = std::make_unique<const VtkArrays>(path, VtkDataKind::kImageData);
  const VtiHeader& vti = arrays->header();
  const VtiArray array =
      chosen_array(path, vti.arrays, {vti.scalars, vti.cell_scalars}, choice.array);

  ImageHeader header{
      .type = array.type, .values = kNumbersAsStored, .components = array.components};
  std::array<Vec3, 3> steps{};
  const Vec3 spacing = vti.spacing.value_or(Vec3{1, 1, 1});
  Vec3 origin = vti.origin.value_or(Vec3{});
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t low = vti.piece[2 * axis];
    const std::int64_t cells = vti.piece[2 * axis + 1] - low;
    header.dims[axis] = array.of_cells ? std::max<std::int64_t>(cells, 1) : cells + 1;
    const double first = static_cast<double>(low) + (array.of_cells && cells > 0 ? 0.5 : 0.0);
    for (std::size_t row = 0; row < 3; ++row) {
      steps[axis][row] = vti.directions[axis][row] * spacing[axis];
      origin[row] += steps[axis][row] * first;
    }
  }
  set_axes(header, steps, vti.origin ? stated(origin) : kNotStated);
  if (!vti.spacing) header.geometry.spacing = kNotStated;
  check_header(path, header);
  auto bytes = arrays->open(array, static_cast<std::uint64_t>(header.dims[0]) *
                                       static_cast<std::uint64_t>(header.dims[1]) *
                                       static_cast<std::uint64_t>(header.dims[2]) *
                                       static_cast<std::uint64_t>(header.components));
  const std::size_t slice_bytes = header.slice_bytes();
  VtiPiece piece{.volume = {.header = header,
                            .slices = nullptr,
                            .notices = choice_notices(path, vti.arrays, array, choice.array),
                            .contents = contents_beside(vti.arrays, array)},
                 .extent = vti.piece,
                 .of_cells = array.of_cells,
                 .is_part = vti.piece != vti.extent};
  piece.volume.contents.times.at = time_of(*arrays);
  // Last, since this moves `arrays`, which owns the header.
  piece.volume.slices =
      std::make_unique<VtiSlices>(std::move(arrays), std::move(bytes), slice_bytes);
  return piece;
}

StoredVolume open_vti(const fs::path& path, const VolumeChoice& choice) {
  VtiPiece piece = open_vti_piece(path, choice);
  if (!piece.is_part) return std::move(piece.volume);
  fail_reading(path, "it is a piece of a larger image",
               "Give the .pvti file that lists its pieces");
}

}  // namespace multitetra
