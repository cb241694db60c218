#include "common/cli/threshold_image.hpp"

#include <itkBMPImageIOFactory.h>
#include <itkBioRadImageIOFactory.h>
#include <itkGiplImageIOFactory.h>
#include <itkImage.h>
#include <itkImageFileReader.h>
#include <itkJPEGImageIOFactory.h>
#include <itkMRCImageIOFactory.h>
#include <itkMetaImageIOFactory.h>
#include <itkNiftiImageIOFactory.h>
#include <itkNrrdImageIOFactory.h>
#include <itkPNGImageIOFactory.h>
#include <itkStimulateImageIOFactory.h>
#include <itkTIFFImageIOFactory.h>
#include <itkVTKImageIOFactory.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/base/child_process.hpp"
#include "common/base/itk_words.hpp"
#include "common/request/threshold_shrinking.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;
using Image = itk::Image<float, 3>;

// Images of the largest size as ITK converts them, and their copy.
constexpr std::uint64_t kMostMemory = std::uint64_t{16} << 30;
constexpr std::chrono::minutes kMostReadingTime{5};
constexpr double kMaxImageSamples = 536870912;  // 2^29: two gigabytes of floats.

// Not HDF5, MINC and DICOM: their libraries would load another 40 ms at every start of our
// programs.
void register_formats() {
  [[maybe_unused]] static const bool registered = [] {
    itk::NrrdImageIOFactory::RegisterOneFactory();
    itk::MetaImageIOFactory::RegisterOneFactory();
    itk::NiftiImageIOFactory::RegisterOneFactory();
    itk::VTKImageIOFactory::RegisterOneFactory();
    itk::TIFFImageIOFactory::RegisterOneFactory();
    itk::GiplImageIOFactory::RegisterOneFactory();
    itk::MRCImageIOFactory::RegisterOneFactory();
    itk::BioRadImageIOFactory::RegisterOneFactory();
    itk::StimulateImageIOFactory::RegisterOneFactory();
    itk::PNGImageIOFactory::RegisterOneFactory();
    itk::BMPImageIOFactory::RegisterOneFactory();
    itk::JPEGImageIOFactory::RegisterOneFactory();
    return true;
  }();
}

tl::unexpected<Error> cannot_read(const fs::path& file, const std::string& problem,
                                  const std::string& remedy,
                                  ErrorCode code = ErrorCode::kInvalidArgument) {
  return fail(code, "Cannot read the threshold grid \"" + file.string() + "\": " + problem + "; " +
                        remedy + ".");
}

// What is wrong with the image as its header tells it.
std::optional<std::string> header_problem(const itk::ImageIOBase& io) {
  if (io.GetNumberOfComponents() != 1) {
    return "each sample has " + std::to_string(io.GetNumberOfComponents()) + " components";
  }
  if (io.GetNumberOfDimensions() < 2) return "it has one dimension";
  for (unsigned axis = 0; axis < io.GetNumberOfDimensions(); ++axis) {
    if (io.GetDimensions(axis) < 1) return "it is empty";
    if (axis >= 3 && io.GetDimensions(axis) > 1) {
      return "it has " + std::to_string(io.GetNumberOfDimensions()) + " dimensions";
    }
  }
  return std::nullopt;
}

// The samples' places, from the header as it is: with the origin in the middle of the first sample.
ThresholdSamples places_of(const itk::ImageIOBase& io) {
  ThresholdSamples image{.dims = {1, 1, 1}, .index_to_world = {}, .thresholds = {}};
  const std::size_t axes = std::min<std::size_t>(io.GetNumberOfDimensions(), 3);
  for (std::size_t axis = 0; axis < axes; ++axis) {
    const auto index = static_cast<unsigned>(axis);
    image.dims[axis] = static_cast<std::int32_t>(io.GetDimensions(index));
    const std::vector<double> direction = io.GetDirection(index);
    Vec3& column = image.index_to_world.columns[axis];
    column = {0, 0, 0};
    for (std::size_t row = 0; row < std::min<std::size_t>(direction.size(), 3); ++row) {
      column[row] = direction[row] * io.GetSpacing(index) + 0.0;  // No -0.
    }
    image.index_to_world.translation[axis] = io.GetOrigin(index);
  }
  return image;
}

// An image, or what is wrong with it, as bytes: 'i', a ThresholdSamples without its samples, and
// these; or 'e', the error's code, and its text.
struct PlainImage {
  std::array<std::int32_t, 3> dims;
  Affine index_to_world;
};

std::string bytes_of_error(const tl::unexpected<Error>& error) {
  return std::string(1, 'e') + static_cast<char>(error.value().code) + error.value().text;
}

std::string read(const fs::path& file) {
  register_formats();
  const auto io = itk::ImageIOFactory::CreateImageIO(file.c_str(),
                                                     itk::ImageIOFactory::IOFileModeEnum::ReadMode);
  if (!io) {
    return bytes_of_error(cannot_read(file, "it is in no format known here",
                                      "give a NRRD, MetaImage, NIfTI or another image file"));
  }
  io->SetFileName(file.string());
  io->ReadImageInformation();
  if (const auto problem = header_problem(*io)) {
    return bytes_of_error(cannot_read(file, *problem, "give a volume with one number per sample"));
  }
  double samples = 1;
  for (unsigned axis = 0; axis < io->GetNumberOfDimensions(); ++axis) {
    samples *= static_cast<double>(io->GetDimensions(axis));
  }
  if (samples > kMaxImageSamples) {
    return bytes_of_error(cannot_read(file, "it has more than 2^29 samples",
                                      "give a coarser one, of the least threshold of each block",
                                      ErrorCode::kLimitExceeded));
  }
  const ThresholdSamples places = places_of(*io);
  const auto reader = itk::ImageFileReader<Image>::New();
  reader->SetImageIO(io);
  reader->SetFileName(file.string());
  reader->Update();
  const PlainImage plain = {.dims = places.dims, .index_to_world = places.index_to_world};
  std::string bytes =
      std::string(1, 'i') + std::string(reinterpret_cast<const char*>(&plain), sizeof(plain));
  bytes.append(reinterpret_cast<const char*>(reader->GetOutput()->GetBufferPointer()),
               static_cast<std::size_t>(samples) * sizeof(float));
  return bytes;
}

Result<ThresholdGrid> grid_from(const std::string& bytes, double elsewhere) {
  if (bytes[0] == 'e') return fail(static_cast<ErrorCode>(bytes[1]), bytes.substr(2));
  PlainImage plain{};
  std::memcpy(&plain, bytes.data() + 1, sizeof(plain));
  std::vector<float> samples((bytes.size() - 1 - sizeof(plain)) / sizeof(float));
  std::memcpy(samples.data(), bytes.data() + 1 + sizeof(plain), samples.size() * sizeof(float));
  return shrunk({.dims = plain.dims, .index_to_world = plain.index_to_world, .thresholds = samples},
                elsewhere);
}

}  // namespace

Result<ThresholdGrid> read_threshold_grid(const fs::path& file, double elsewhere) {
  std::error_code none;
  if (!fs::is_regular_file(file, none)) {
    return cannot_read(file, "there is no such file", "check its name");
  }
  try {
    const auto work = [&] {
      try {
        return read(file);
      } catch (const itk::ExceptionObject& problem) {
        return bytes_of_error(
            cannot_read(file, itk_words(problem.GetDescription()), "give a whole image file"));
      }
    };
    return grid_from(made_apart(work, kMostMemory, kMostReadingTime), elsewhere);
  } catch (const std::runtime_error& problem) {  // Its reader crashed, or takes too long.
    return cannot_read(file, problem.what(), "give a whole image file");
  }
}

}  // namespace multitetra
