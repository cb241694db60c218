#include "server/dataset/image_payload.hpp"

#include <itkMetaImageIO.h>
#include <itkNrrdImageIO.h>
#include <itkTIFFImageIO.h>
#include <itkVTKImageIO.h>

#include <cstdint>
#include <fstream>
#include <string>

#include "common/base/text.hpp"
#include "server/dataset/formats/input_file.hpp"
#include "server/dataset/nrrd_payload.hpp"
#include "server/dataset/payload_size.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

// A stream that is damaged counts as nothing.
void require_inflated(const fs::path& file, std::uint64_t offset, std::uint64_t needed) {
  require_whole(file, inflated_bytes(file, offset).value_or(0), needed);
}

// ---- MetaImage

// Where the samples of a MetaImage with ElementDataFile = LOCAL begin.
std::uint64_t local_data_offset(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string line;
  while (std::getline(in, line)) {
    if (line.starts_with("ElementDataFile")) return static_cast<std::uint64_t>(in.tellg());
  }
  return 0;
}

// The one data file of a MetaImage, and where its samples begin. HeaderSize -1 means that they end
// the file.
PayloadPart meta_image_data(const fs::path& file, const MetaImage& meta, std::uint64_t bytes) {
  const std::string data_name = meta.ElementDataFileName();
  const bool local = data_name == "LOCAL" || data_name == "Local" || data_name == "local";
  const bool several = data_name.starts_with("LIST") || data_name.find('%') != std::string::npos;
  if (several) {
    fail_reading(file, "it lists several data files",
                 "Join them into one, or give a NRRD header (.nhdr), which may list slices");
  }
  PayloadPart data{local ? file : file.parent_path() / data_name};
  if (meta.HeaderSize() > 0) {
    data.offset = static_cast<std::uint64_t>(meta.HeaderSize());
  } else if (meta.HeaderSize() == -1 && !meta.CompressedData() && meta.BinaryData()) {
    const std::uint64_t size = bytes_after(data.file, 0);
    data.offset = size < bytes ? 0 : size - bytes;
  } else if (local) {
    data.offset = local_data_offset(file);
  }
  return data;
}

void check_meta_image(const fs::path& file, itk::MetaImageIO& io, std::uint64_t needed) {
  const MetaImage& meta = *io.GetMetaImagePointer();
  const PayloadPart data = meta_image_data(file, meta, needed);
  if (!meta.BinaryData()) {
    const std::uint64_t numbers = static_cast<std::uint64_t>(io.GetImageSizeInComponents());
    require_whole(data.file, numbers_in_text(data.file, data.offset, numbers), numbers, "numbers");
  } else if (meta.CompressedData()) {
    require_inflated(data.file, data.offset, needed);
  } else {
    require_whole(data.file, bytes_after(data.file, data.offset), needed);
  }
}

std::optional<PlainPayload> plain_meta_image(const fs::path& file, itk::MetaImageIO& io,
                                             std::uint64_t bytes, const VolumeInFile& volume) {
  const MetaImage& meta = *io.GetMetaImagePointer();
  if (!meta.BinaryData()) return std::nullopt;
  const std::uint64_t before = bytes * static_cast<std::uint64_t>(volume.index);
  PayloadPart data = meta_image_data(file, meta, bytes * static_cast<std::uint64_t>(volume.count));
  if (data.file == file && data.offset == 0) return std::nullopt;  // Only ITK knows where.
  const Endian endian = meta.BinaryDataByteOrderMSB() ? Endian::kBig : Endian::kLittle;
  if (meta.CompressedData()) return PlainPayload{{data}, bytes, endian, before};
  data.offset += before;
  return PlainPayload{{data}, bytes, endian};
}

// ---- legacy VTK

void check_vtk(const fs::path& file, const itk::VTKImageIO& io, std::uint64_t needed) {
  const auto offset = static_cast<std::uint64_t>(io.GetHeaderSize());
  if (io.GetFileType() == itk::IOFileEnum::ASCII) {
    const std::uint64_t numbers = static_cast<std::uint64_t>(io.GetImageSizeInComponents());
    require_whole(file, numbers_in_text(file, offset, numbers), numbers, "numbers");
  } else {
    require_whole(file, bytes_after(file, offset), needed);
  }
}

std::optional<PlainPayload> plain_vtk(const fs::path& file, const itk::VTKImageIO& io,
                                      std::uint64_t bytes) {
  const auto offset = static_cast<std::uint64_t>(io.GetHeaderSize());
  if (io.GetFileType() == itk::IOFileEnum::ASCII || offset == 0) return std::nullopt;
  return PlainPayload{{{file, offset}}, bytes, Endian::kBig};
}

}  // namespace

void check_meta_image_header(const fs::path& file, bool follow) {
  constexpr std::size_t kMostHeaderBytes = std::size_t{1} << 16;
  const std::string text = InputFile(file).beginning(kMostHeaderBytes);
  const auto value_of = [&](std::string_view key) -> std::optional<std::string> {
    for (std::size_t at = text.find(key); at != std::string::npos; at = text.find(key, at + 1)) {
      if (at > 0 && text[at - 1] != '\n') continue;
      const std::size_t end = text.find('\n', at);
      const std::size_t equals = text.find('=', at);
      if (end == std::string::npos || equals > end) continue;
      std::string value(trimmed(std::string_view(text).substr(equals + 1, end - equals - 1)));
      if (value.ends_with('\r')) value.pop_back();
      return value;
    }
    return std::nullopt;
  };
  const auto dimensions = value_of("NDims");
  if (dimensions && *dimensions != "1" && *dimensions != "2" && *dimensions != "3" &&
      *dimensions != "4") {
    fail_reading(file, "its NDims is '" + dimensions->substr(0, 40) + "'",
                 "Give a volume of 2 or 3");
  }
  const auto data = value_of("ElementDataFile");
  if (!data) {
    fail_reading(file,
                 "there is no line ElementDataFile in its first " +
                     std::to_string(kMostHeaderBytes) + " bytes",
                 "Check that it is a whole file of this format");
  }
  const bool local = *data == "LOCAL" || *data == "Local" || *data == "local";
  const bool several = data->starts_with("LIST") || data->find('%') != std::string::npos;
  if (!local && !several) (void)named_data_file(file, *data, follow);
}

// NRRD needs no check: its reader tells.
void check_payload(const fs::path& file, itk::ImageIOBase& io) {
  const auto needed = static_cast<std::uint64_t>(io.GetImageSizeInBytes());
  if (auto* const meta = dynamic_cast<itk::MetaImageIO*>(&io)) {
    check_meta_image(file, *meta, needed);
  }
  if (auto* const vtk = dynamic_cast<itk::VTKImageIO*>(&io)) check_vtk(file, *vtk, needed);
  if (dynamic_cast<itk::TIFFImageIO*>(&io) != nullptr && !tiff_directories_are_whole(file)) {
    fail_reading(file, "it ends before its last page", "Get a whole copy of it");
  }
}

std::optional<PlainPayload> plain_payload(const fs::path& file, const ImageHeader& header,
                                          const VolumeInFile& volume, itk::ImageIOBase& io) {
  const std::uint64_t bytes = header.slice_bytes() * static_cast<std::uint64_t>(header.dims[2]);
  if (dynamic_cast<itk::NrrdImageIO*>(&io) != nullptr) return plain_nrrd_payload(file, header);
  if (auto* const meta = dynamic_cast<itk::MetaImageIO*>(&io)) {
    return plain_meta_image(file, *meta, bytes, volume);
  }
  if (auto* const vtk = dynamic_cast<itk::VTKImageIO*>(&io)) return plain_vtk(file, *vtk, bytes);
  return std::nullopt;
}

}  // namespace multitetra
