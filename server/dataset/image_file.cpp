#include "server/dataset/image_file.hpp"

#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkNrrdImageIO.h>
#include <itkTIFFImageIO.h>
#include <itkVTKImageIO.h>

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/itk_words.hpp"
#include "server/dataset/image_payload.hpp"
#include "server/dataset/nrrd_header.hpp"
#include "server/dataset/nrrd_payload.hpp"
#include "server/dataset/nrrd_series.hpp"
#include "server/dataset/payload_size.hpp"
#include "server/dataset/segment_names.hpp"
#include "server/dataset/volume_source.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;
using Component = itk::IOComponentEnum;
using ImageIo = itk::ImageIOBase::Pointer;

// ---- what a header says

StoredType stored_type(const fs::path& file, Component component) {
  switch (component) {
    case Component::UCHAR:
      return StoredType::kU8;
    case Component::CHAR:
      return StoredType::kI8;
    case Component::USHORT:
      return StoredType::kU16;
    case Component::SHORT:
      return StoredType::kI16;
    case Component::UINT:
      return StoredType::kU32;
    case Component::INT:
      return StoredType::kI32;
    case Component::ULONG:
    case Component::ULONGLONG:
      return StoredType::kU64;
    case Component::LONG:
    case Component::LONGLONG:
      return StoredType::kI64;
    case Component::FLOAT:
      return StoredType::kF32;
    case Component::DOUBLE:
      return StoredType::kF64;
    default:
      fail_reading(file, "the type of its samples is not known",
                   "Give integers of 8 to 64 bits or floating-point numbers of 32 or 64 bits");
  }
}

// ITK turns the patients' axes that NRRD and MetaImage know into LPS. Without them axes are the
// file's own.
PhysicalMeaning meaning_of(const itk::ImageIOBase& io) {
  std::string space;
  itk::ExposeMetaData<std::string>(io.GetMetaDataDictionary(), "NRRD_space", space);
  if (const auto* const meta = dynamic_cast<const itk::MetaImageIO*>(&io)) {
    space =
        const_cast<itk::MetaImageIO*>(meta)->GetMetaImagePointer()->AnatomicalOrientationAcronym();
    if (space.substr(0, 3).find('?') != std::string::npos) space.clear();
  }
  if (space.empty()) return {};
  return {.space = WorldSpace::kLps, .length_unit = "mm", .value_unit = {}};
}

ImageHeader header_of(const fs::path& file, const itk::ImageIOBase& io, bool is_series) {
  ImageHeader header;
  header.type = stored_type(file, io.GetComponentType());
  header.components = io.GetNumberOfComponents();
  header.meaning = meaning_of(io);
  for (unsigned axis = 0; axis < io.GetNumberOfDimensions(); ++axis) {
    const auto side = static_cast<std::int64_t>(io.GetDimensions(axis));
    if (axis < 3) {
      header.dims[axis] = side;
    } else if (side != 1 && !(axis == 3 && is_series)) {
      fail_reading(file,
                   "it has " + std::to_string(io.GetNumberOfDimensions()) + " dimensions and " +
                       std::to_string(side) + " volumes along dimension " +
                       std::to_string(axis + 1),
                   "Give a single volume of three dimensions, for example one time step");
    }
  }
  const auto axes = std::min<std::size_t>(io.GetNumberOfDimensions(), 3);
  if (axes < 2) fail_reading(file, "it has one dimension", "Give an image or a volume");
  for (std::size_t axis = 0; axis < axes; ++axis) {
    const auto index = static_cast<unsigned>(axis);
    const double step = io.GetSpacing(index);
    const std::vector<double> direction = io.GetDirection(index);
    if (!std::isfinite(step) || step == 0) {
      fail_reading(
          file,
          "its spacing along axis " + std::to_string(axis + 1) + " is " + std::to_string(step),
          "Correct the header: spacings are positive numbers");
    }
    header.spacing[axis] = std::abs(step);
    header.index_to_world.columns[axis] = {0, 0, 0};
    for (std::size_t row = 0; row < std::min<std::size_t>(direction.size(), 3); ++row) {
      header.index_to_world.columns[axis][row] = direction[row] * step + 0.0;  // No -0.
    }
    header.index_to_world.translation[axis] = io.GetOrigin(index);
  }
  const double volume = header.index_to_world.determinant();
  if (!std::isfinite(volume) || volume == 0) {
    fail_reading(file, "its directions do not span space",
                 "Correct the header: the three directions must be independent");
  }
  return header;
}

// ---- which reader

ImageIo io_for(VolumeFormat format) {
  switch (format) {
    case VolumeFormat::kNrrd:
      return itk::NrrdImageIO::New().GetPointer();
    case VolumeFormat::kMetaImage:
      return itk::MetaImageIO::New().GetPointer();
    case VolumeFormat::kLegacyVtk:
      return itk::VTKImageIO::New().GetPointer();
    default:
      return itk::TIFFImageIO::New().GetPointer();
  }
}

// A header under a name of its own for as long as ITK reads it.
class TemporaryHeader {
 public:
  explicit TemporaryHeader(const std::string& text) {
    std::string pattern = (fs::temp_directory_path() / "multitetra-XXXXXX.nhdr").string();
    const int descriptor = mkstemps(pattern.data(), static_cast<int>(std::strlen(".nhdr")));
    if (descriptor < 0) {
      throw fs::filesystem_error("", pattern, std::error_code(errno, std::generic_category()));
    }
    close(descriptor);
    path_ = pattern;
    std::ofstream(path_, std::ios::binary) << text;
  }
  TemporaryHeader(const TemporaryHeader&) = delete;
  TemporaryHeader& operator=(const TemporaryHeader&) = delete;
  ~TemporaryHeader() {
    std::error_code error;
    fs::remove(path_, error);
  }
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

// ---- samples

void fill_from(const itk::ImageIOBase::Pointer& io, void* memory) {
  itk::ImageIORegion region(io->GetNumberOfDimensions());
  for (unsigned axis = 0; axis < io->GetNumberOfDimensions(); ++axis) {
    region.SetIndex(axis, 0);
    region.SetSize(axis, io->GetDimensions(axis));
  }
  io->SetIORegion(region);
  io->Read(memory);
}

}  // namespace

struct ImageFile::Reader {
  ImageIo io;
  std::optional<TemporaryHeader> rewritten;
  bool is_of_series = false;  // The rewritten header: of one of its volumes.
};

std::optional<std::int64_t> ImageFile::chosen_time(const VolumeChoice& choice) const {
  const std::int64_t count = members_.times.count;
  if (count > 1 && !choice.time && !choice.first) {
    fail_reading(file_, "it has " + std::to_string(count) + " volumes, one for each time",
                 "Choose one with --time, from 0 on, or prepare them with --all-times");
  }
  const std::int64_t time = choice.time.value_or(0);
  if (time < 0 || time >= count) {
    fail_reading(file_, "it has no time " + std::to_string(time),
                 "Choose 0 to " + std::to_string(count - 1));
  }
  return count > 1 ? std::optional(time) : std::nullopt;
}

ImageFile::ImageFile(const fs::path& file, VolumeFormat format, const VolumeChoice& choice)
    : file_(file), reader_(std::make_unique<Reader>()) {
  reader_->io = io_for(format);
  if (format == VolumeFormat::kMetaImage) check_meta_image_header(file, choice.follow);
  if (format == VolumeFormat::kTiff && !tiff_directories_are_whole(file)) {
    fail_reading(file, "its chain of pages leads out of the file or in a circle",
                 "Get a whole copy of it");
  }
  std::string nrrd;
  if (format == VolumeFormat::kNrrd) {
    check_nrrd_header(file, choice.follow);
    std::string header = nrrd = read_nrrd_header(file);
    members_.labels = segments_in(nrrd);
    // Of a segmentation they are layers, which overlap, not times.
    const bool is_component =
        have_layers(members_.labels) || (!choice.time && choice.component != ComponentChoice());
    if (const auto series = nrrd_series(header, is_component)) {
      members_.times = series->times;
      const auto time = chosen_time(choice);
      if (time && series->is_interleaved) component_of_time_ = static_cast<int>(*time);
      reader_->is_of_series = time && !series->is_interleaved;
      if (reader_->is_of_series) header = nrrd_header_at(header, file, *time);
    }
    const auto rewritten = rewritten_nrrd_header(header, file);
    if (rewritten || reader_->is_of_series) reader_->rewritten.emplace(rewritten.value_or(header));
  }
  try {
    reader_->io->SetFileName((reader_->rewritten ? reader_->rewritten->path() : file).string());
    reader_->io->ReadImageInformation();
  } catch (const itk::ExceptionObject& problem) {
    fail_reading(file, itk_words(problem.GetDescription()),
                 "Check that it is a whole file of this format");
  }
  const bool is_meta_series =
      format == VolumeFormat::kMetaImage && reader_->io->GetNumberOfDimensions() == 4;
  header_ = header_of(file, *reader_->io, is_meta_series);
  if (have_layers(members_.labels)) {
    members_.labels = segments_in(nrrd, header_.components);
    if (header_.components > 1 && choice.component == ComponentChoice() && !choice.first) {
      fail_reading(file,
                   "it is a segmentation: " + std::to_string(members_.labels.size()) +
                       " segments in " + std::to_string(header_.components) +
                       " layers, as some overlap",
                   "Prepare each segment with --label all -o FOLDER/, or the numbers of one layer "
                   "with --component, from 0 on");
    }
  }
  if (!is_meta_series) return;
  volume_.count = static_cast<std::int64_t>(reader_->io->GetDimensions(3));
  members_.times = even_times(volume_.count, reader_->io->GetOrigin(3), reader_->io->GetSpacing(3),
                              /*unit=*/"");
  volume_.index = chosen_time(choice).value_or(0);
}

ImageFile::~ImageFile() = default;
ImageFile::ImageFile(ImageFile&&) noexcept = default;

std::optional<PlainPayload> ImageFile::plain_payload() const {
  const fs::path& file = reader_->is_of_series ? reader_->rewritten->path() : file_;
  const auto payload = multitetra::plain_payload(file, header_, volume_, *reader_->io);
  if (!payload && volume_.count > 1) {
    fail_reading(file_, "its samples are text and it has several volumes", "Save it as binary");
  }
  return payload;
}

void ImageFile::read(void* memory) const {
  try {
    check_payload(file_, *reader_->io);
    fill_from(reader_->io, memory);
  } catch (const itk::ExceptionObject& problem) {
    fail_reading(file_, itk_words(problem.GetDescription()),
                 "Check that the file and the data files it names are whole");
  }
}

}  // namespace multitetra
