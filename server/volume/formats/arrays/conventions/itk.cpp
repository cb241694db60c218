#include "server/volume/formats/arrays/conventions/known_conventions.hpp"

namespace multitetra {
namespace {

constexpr const char* kImage = "/ITKImage/0/";

}  // namespace

std::vector<std::string> itk_arrays(const ArrayContainer& file, const VolumeChoice&) {
  const std::string voxels = std::string(kImage) + "VoxelData";
  return file.shape(voxels).empty() ? std::vector<std::string>() : std::vector{voxels};
}

// Voxels (z, y, x, or with components behind); a row of Directions is that of an axis.
bool describe_itk(const ArrayContainer& file, const std::string& array, ArrayMeaning& meaning) {
  const std::string image = kImage;
  const std::size_t rank = file.shape(array).size();
  const std::vector<double> spacing = file.values(image + "Spacing");
  const std::vector<double> first = file.values(image + "Origin");
  const std::vector<double> rows = file.values(image + "Directions");
  const std::size_t axes = spacing.size();
  if (array != image + "VoxelData" || axes < 2 || axes > 3 || (rank != axes && rank != axes + 1))
    return false;
  for (std::size_t axis = axes; axis-- > 0;) {
    meaning.roles.push_back(static_cast<DimensionRole>(axis));
  }
  if (rank > axes) meaning.roles.push_back(DimensionRole::kComponent);
  std::array<Vec3, 3> steps{};
  StatedNumbers origin = kNotStated;
  for (std::size_t axis = 0; axis < axes; ++axis) {
    for (std::size_t row = 0; row < axes; ++row) {
      const double own = row == axis ? 1 : 0;
      const double cosine = rows.size() == axes * axes ? rows[axes * axis + row] : own;
      steps[axis][row] = cosine * spacing[axis];
    }
    if (first.size() == axes) origin[axis] = first[axis];
  }
  set_axes(meaning.header, steps, origin);
  return true;
}

}  // namespace multitetra
