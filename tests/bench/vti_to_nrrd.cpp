// Turns VTK's image file (.vti), which our readers do not read, into a NRRD that they do.
//
//   vti_to_nrrd embryo.vti embryo.nrrd
//
// The samples are the active scalars at the points, or else the first array there. 8-bit and 16-bit
// integers and 32-bit floats keep their type and their bits; others become f32, which is told.

#include <array>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include <vtkDataArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkXMLImageDataReader.h>

#include "server/dataset/written_nrrd.hpp"

namespace multitetra {
namespace {

constexpr int kMaxSide = 16385;

[[noreturn]] void fail_on(const std::string& file, const std::string& what) {
  throw std::runtime_error("'" + file + "': " + what);
}

vtkDataArray& scalars_of(const std::string& file, vtkImageData& image) {
  vtkPointData& points = *image.GetPointData();
  vtkDataArray* array = points.GetScalars();
  if (array == nullptr) array = points.GetArray(0);
  if (array == nullptr) fail_on(file, "it has no array of numbers at its points.");
  if (array->GetNumberOfComponents() != 1) {
    fail_on(file, "its samples have " + std::to_string(array->GetNumberOfComponents()) +
                      " components; one is needed.");
  }
  if (array->GetNumberOfTuples() != image.GetNumberOfPoints()) {
    fail_on(file, "it has " + std::to_string(array->GetNumberOfTuples()) + " samples at " +
                      std::to_string(image.GetNumberOfPoints()) + " points.");
  }
  return *array;
}

template <typename Sample>
Samples samples_as(vtkDataArray& array) {
  std::vector<Sample> samples(static_cast<std::size_t>(array.GetNumberOfTuples()));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i] = static_cast<Sample>(array.GetTuple1(static_cast<vtkIdType>(i)));
  }
  return samples;
}

Samples samples_of(const std::string& file, vtkDataArray& array) {
  switch (array.GetDataType()) {
    case VTK_UNSIGNED_CHAR:
      return samples_as<std::uint8_t>(array);
    case VTK_SIGNED_CHAR:
      return samples_as<std::int8_t>(array);
    case VTK_CHAR:
      return samples_as<std::conditional_t<std::is_signed_v<char>, std::int8_t, std::uint8_t>>(
          array);
    case VTK_UNSIGNED_SHORT:
      return samples_as<std::uint16_t>(array);
    case VTK_SHORT:
      return samples_as<std::int16_t>(array);
    case VTK_FLOAT:
      break;
    default:
      std::cerr << "'" << file << "': its samples of type " << array.GetDataTypeAsString()
                << " become f32.\n";
  }
  return samples_as<float>(array);
}

// VTK counts indices from the extent's first point, which need not be 0.
Affine index_to_world(vtkImageData& image) {
  std::array<int, 6> extent{};
  image.GetExtent(extent.data());
  const auto point_at = [&](int i, int j, int k) {
    Vec3 point{};
    image.TransformIndexToPhysicalPoint(extent[0] + i, extent[2] + j, extent[4] + k, point.data());
    return point;
  };
  Affine map{.translation = point_at(0, 0, 0)};
  const std::array<Vec3, 3> ends = {point_at(1, 0, 0), point_at(0, 1, 0), point_at(0, 0, 1)};
  for (std::size_t column = 0; column < 3; ++column) {
    for (std::size_t row = 0; row < 3; ++row) {
      map.columns[column][row] = ends[column][row] - map.translation[row];
    }
  }
  return map;
}

Volume volume_from_vti(const std::string& file) {
  if (!std::filesystem::is_regular_file(file)) fail_on(file, "there is no such file.");
  vtkNew<vtkXMLImageDataReader> reader;
  if (reader->CanReadFile(file.c_str()) == 0) fail_on(file, "it is not a VTK image file (.vti).");
  reader->SetFileName(file.c_str());
  reader->Update();
  vtkImageData& image = *reader->GetOutput();
  Volume volume;
  image.GetDimensions(volume.dims.data());
  for (const int side : volume.dims) {
    if (side < 1 || side > kMaxSide) {
      fail_on(file, "it has " + std::to_string(side) + " samples along a side; 1 to " +
                        std::to_string(kMaxSide) + " can be used.");
    }
  }
  image.GetSpacing(volume.spacing.data());
  volume.index_to_world = index_to_world(image);
  volume.samples = samples_of(file, scalars_of(file, image));
  return volume;
}

}  // namespace
}  // namespace multitetra

int main(int count, char** arguments) {
  if (count != 3) {
    std::cerr << "Usage: vti_to_nrrd IN.vti OUT.nrrd\n";
    return 2;
  }
  try {
    multitetra::write_nrrd(arguments[2], multitetra::volume_from_vti(arguments[1]));
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "vti_to_nrrd: " << error.what() << "\n";
    return 1;
  }
}
