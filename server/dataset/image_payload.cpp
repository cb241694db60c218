#include "server/dataset/image_payload.hpp"

#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <itkTIFFImageIO.h>
#include <itkVTKImageIO.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>

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
                                             std::uint64_t bytes) {
  const MetaImage& meta = *io.GetMetaImagePointer();
  if (!meta.BinaryData() || meta.CompressedData()) return std::nullopt;
  const PayloadPart data = meta_image_data(file, meta, bytes);
  if (data.file == file && data.offset == 0) return std::nullopt;  // Only ITK knows where.
  const Endian endian = meta.BinaryDataByteOrderMSB() ? Endian::kBig : Endian::kLittle;
  return PlainPayload{{data}, bytes, endian};
}

// ---- NIfTI and legacy VTK

void check_nifti(const fs::path& file, itk::NiftiImageIO& io) {
  const auto number = [&](const char* key) {
    std::string text;
    itk::ExposeMetaData<std::string>(io.GetMetaDataDictionary(), key, text);
    return std::strtod(text.c_str(), nullptr);
  };
  const double bytes =
      number("vox_offset") + static_cast<double>(io.GetImageSizeInPixels()) * number("bitpix") / 8;
  require_inflated(file, 0, static_cast<std::uint64_t>(bytes));
}

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

// NRRD needs no check: its reader tells.
void check_payload(const fs::path& file, itk::ImageIOBase& io) {
  const auto needed = static_cast<std::uint64_t>(io.GetImageSizeInBytes());
  if (auto* const meta = dynamic_cast<itk::MetaImageIO*>(&io)) {
    check_meta_image(file, *meta, needed);
  }
  if (auto* const nifti = dynamic_cast<itk::NiftiImageIO*>(&io)) check_nifti(file, *nifti);
  if (auto* const vtk = dynamic_cast<itk::VTKImageIO*>(&io)) check_vtk(file, *vtk, needed);
  if (dynamic_cast<itk::TIFFImageIO*>(&io) != nullptr && !tiff_directories_are_whole(file)) {
    fail_reading(file, "it ends before its last page", "Get a whole copy of it");
  }
}

std::optional<PlainPayload> plain_payload(const fs::path& file, const ImageHeader& header,
                                          itk::ImageIOBase& io) {
  const std::uint64_t bytes =
      static_cast<std::uint64_t>(header.dims[0] * header.dims[1] * header.dims[2]) *
      bytes_of(header.type);
  if (dynamic_cast<itk::NrrdImageIO*>(&io) != nullptr) return plain_nrrd_payload(file, header);
  if (auto* const meta = dynamic_cast<itk::MetaImageIO*>(&io)) {
    return plain_meta_image(file, *meta, bytes);
  }
  if (auto* const vtk = dynamic_cast<itk::VTKImageIO*>(&io)) return plain_vtk(file, *vtk, bytes);
  return std::nullopt;
}

}  // namespace multitetra
