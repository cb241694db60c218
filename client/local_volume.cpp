// The client's one file that sees ITK.
#include "client/local_volume.hpp"

#include <itkImage.h>
#include <itkImageFileReader.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <itkTIFFImageIO.h>
#include <itkVTKImageIO.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

#include "common/base/child_process.hpp"
#include "common/base/itk_words.hpp"
#include "common/base/text.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::minutes kMostReadingTime{20};
constexpr const char* kFormats = ".nrrd, .nhdr, .mha, .mhd, .nii, .nii.gz, .vtk, .tif and .tiff";

[[noreturn]] void fail_reading(const fs::path& file, const std::string& problem) {
  throw std::runtime_error("Cannot check against '" + file.string() + "': " + problem + ".");
}

itk::ImageIOBase::Pointer reader_for(const fs::path& file) {
  const std::string name = lower_case(file.filename().string());
  const auto ends_with = [&](auto... suffixes) { return (name.ends_with(suffixes) || ...); };
  if (ends_with(".nrrd", ".nhdr")) return itk::NrrdImageIO::New().GetPointer();
  if (ends_with(".mha", ".mhd")) return itk::MetaImageIO::New().GetPointer();
  if (ends_with(".nii", ".nii.gz")) return itk::NiftiImageIO::New().GetPointer();
  if (ends_with(".vtk")) return itk::VTKImageIO::New().GetPointer();
  if (ends_with(".tif", ".tiff")) return itk::TIFFImageIO::New().GetPointer();
  return nullptr;
}

std::string text_of(const auto& numbers) {
  std::ostringstream text;
  for (std::size_t i = 0; i < numbers.size(); ++i) text << (i == 0 ? "" : " x ") << numbers[i];
  return text.str();
}

std::size_t samples_of(const DatasetInfo& info) {
  std::size_t count = 1;
  for (const std::int32_t side : info.dims) count *= static_cast<std::size_t>(side);
  return count;
}

// ---- files with a header

std::vector<float> read_image(const fs::path& file, itk::ImageIOBase* io, const DatasetInfo& info) {
  using Image = itk::Image<double, 3>;
  const auto reader = itk::ImageFileReader<Image>::New();
  reader->SetImageIO(io);
  reader->SetFileName(file.string());
  try {
    reader->UpdateOutputInformation();
    const Image& image = *reader->GetOutput();
    const auto& size = image.GetLargestPossibleRegion().GetSize();
    std::array<std::int32_t, 3> dims{};
    Vec3 spacing{};
    for (unsigned axis = 0; axis < 3; ++axis) {
      dims[axis] = static_cast<std::int32_t>(size[axis]);
      spacing[axis] = image.GetSpacing()[axis];
    }
    if (dims != info.dims) {
      fail_reading(file, "it has " + text_of(dims) + " samples, the dataset \"" + info.name +
                             "\" has " + text_of(info.dims));
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (std::abs(spacing[axis] - info.spacing[axis]) > 1e-6 * info.spacing[axis]) {
        fail_reading(file, "its spacing is " + text_of(spacing) + ", that of the dataset \"" +
                               info.name + "\" is " + text_of(info.spacing));
      }
    }
    reader->Update();
  } catch (const itk::ExceptionObject& problem) {
    fail_reading(file, itk_words(problem.GetDescription()) +
                           "; save it in another format or as raw samples");
  }
  const double* first = reader->GetOutput()->GetBufferPointer();
  return {first, first + samples_of(info)};
}

// The same in a process of its own: files that crash or hang their reader are refused.
std::vector<float> read_image_apart(const fs::path& file, itk::ImageIOBase* io,
                                    const DatasetInfo& info) {
  const std::uint64_t bytes = samples_of(info) * sizeof(float);
  // ITK reads it as doubles, from whatever type it has.
  const std::uint64_t memory = 8 * bytes + (std::uint64_t{1} << 30);
  try {
    const std::string made = made_apart(
        [&] {
          const std::vector<float> samples = read_image(file, io, info);
          return std::string(reinterpret_cast<const char*>(samples.data()), bytes);
        },
        memory, kMostReadingTime);
    std::vector<float> samples(samples_of(info));
    std::memcpy(samples.data(), made.data(), bytes);
    return samples;
  } catch (const ChildProcessError& problem) {
    fail_reading(file, problem.what());
  }
}

// ---- raw samples

template <typename Sample>
std::vector<float> samples_in(const std::string& bytes, bool turn_around) {
  std::vector<float> samples(bytes.size() / sizeof(Sample));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    std::array<char, sizeof(Sample)> one;
    std::memcpy(one.data(), bytes.data() + i * sizeof(Sample), sizeof(Sample));
    if (turn_around) std::reverse(one.begin(), one.end());
    Sample value;
    std::memcpy(&value, one.data(), sizeof(Sample));
    samples[i] = static_cast<float>(value);
  }
  return samples;
}

std::vector<float> samples_in(const std::string& bytes, SampleType type, bool turn_around) {
  switch (type) {
    case SampleType::kU8:
      return samples_in<std::uint8_t>(bytes, turn_around);
    case SampleType::kI8:
      return samples_in<std::int8_t>(bytes, turn_around);
    case SampleType::kU16:
      return samples_in<std::uint16_t>(bytes, turn_around);
    case SampleType::kI16:
      return samples_in<std::int16_t>(bytes, turn_around);
    case SampleType::kF32:
      return samples_in<float>(bytes, turn_around);
  }
  return {};
}

std::string raw_bytes(const fs::path& file, const DatasetInfo& info) {
  std::ifstream stream(file, std::ios::binary | std::ios::ate);
  if (!stream || fs::is_directory(file)) {
    fail_reading(file, "it is no file that can be read; give one of " + std::string(kFormats));
  }
  const auto wanted = static_cast<std::streamoff>(
      samples_of(info) * static_cast<std::size_t>(bytes_per_sample(info.type)));
  if (stream.tellg() < wanted) {
    fail_reading(file, "its suffix is none of " + std::string(kFormats) +
                           ", and it is too short for raw samples: it has " +
                           std::to_string(stream.tellg()) + " bytes; " + text_of(info.dims) +
                           " samples of type " + std::string(name(info.type)) + " need " +
                           std::to_string(wanted));
  }
  stream.seekg(-wanted, std::ios::end);
  std::string bytes(static_cast<std::size_t>(wanted), '\0');
  if (!stream.read(bytes.data(), wanted)) fail_reading(file, "it cannot be read");
  return bytes;
}

// ---- is it the dataset's?

void make_infinite_void(std::vector<float>& samples) {
  for (float& sample : samples) {
    if (std::isinf(sample)) sample = std::numeric_limits<float>::quiet_NaN();
  }
}

std::pair<double, double> range_of(const std::vector<float>& samples) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const float sample : samples) {
    if (std::isnan(sample)) continue;
    low = std::min(low, static_cast<double>(sample));
    high = std::max(high, static_cast<double>(sample));
  }
  return {low, high};
}

bool has_range_of(const DatasetInfo& info, const std::vector<float>& samples) {
  return range_of(samples) == std::pair(info.min, info.max);
}

}  // namespace

std::vector<float> read_local_volume(const fs::path& file, const DatasetInfo& info) {
  if (!fs::exists(file)) fail_reading(file, "there is no such file");
  std::vector<float> samples;
  const auto io = reader_for(file);
  if (io) {
    samples = read_image_apart(file, io, info);
    make_infinite_void(samples);
  } else {
    const std::string bytes = raw_bytes(file, info);
    for (const bool turn_around : {false, true}) {
      samples = samples_in(bytes, info.type, turn_around);
      make_infinite_void(samples);
      if (has_range_of(info, samples)) break;
    }
  }
  if (!has_range_of(info, samples)) {
    const auto [low, high] = range_of(samples);
    std::ostringstream text;
    if (!io) {
      text << "taken for raw samples, because its suffix is none of " << kFormats << ", ";
    }
    text << "its values are from " << low << " to " << high << ", those of the dataset \""
         << info.name << "\" from " << info.min << " to " << info.max;
    fail_reading(file, text.str());
  }
  return samples;
}

}  // namespace multitetra
