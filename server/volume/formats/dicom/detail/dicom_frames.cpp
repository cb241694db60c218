#include "server/volume/formats/dicom/detail/dicom_frames.hpp"

#include <gdcmFragment.h>
#include <gdcmMediaStorage.h>
#include <gdcmPixmapReader.h>
#include <gdcmReader.h>
#include <gdcmSequenceOfFragments.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "server/volume/formats/detail/input_file.hpp"

namespace multitetra {
namespace {

constexpr const char* kSaveUncompressed = "Save it without compression, by the program it is from";

// Moves the image.stored_bits bits of each sample to the lowest ones, where JPEG streams have them,
// and repeats their sign above.
void take_stored_bits(const DicomImage& image, std::span<std::byte> pixels) {
  const int above = 8 * static_cast<int>(bytes_of(image.type)) - image.stored_bits;
  const int below = image.is_jpeg ? 0 : image.unused_bits;
  if (image.stored_bits <= 0 || above <= 0 || image.has_bits) return;
  with_number_type(image.type, [&]<typename Number>() {
    if constexpr (std::is_integral_v<Number>) {
      for (std::size_t at = 0; at + sizeof(Number) <= pixels.size(); at += sizeof(Number)) {
        Number number;
        std::memcpy(&number, pixels.data() + at, sizeof number);
        number = static_cast<Number>(static_cast<Number>(number >> below << above) >> above);
        std::memcpy(pixels.data() + at, &number, sizeof number);
      }
    }
  });
}

// Reads the pixels of any storage class, private ones as well. Drops curves, overlays and icons, on
// some of which GDCM aborts.
class PixelReader : public gdcm::PixmapReader {
 public:
  bool read_pixels() {
    if (!gdcm::Reader::Read()) return false;
    gdcm::DataSet& data = GetFile().GetDataSet();
    std::vector<gdcm::Tag> beside = {gdcm::Tag(0x0088, 0x0200)};
    for (const gdcm::DataElement& element : data.GetDES()) {
      const int group = element.GetTag().GetGroup() & 0xFF00;
      if (group == 0x5000 || group == 0x6000) beside.push_back(element.GetTag());
    }
    for (const gdcm::Tag& tag : beside) data.Remove(tag);
    GetPixmap().SetTransferSyntax(GetFile().GetHeader().GetDataSetTransferSyntax());
    return ReadImage(gdcm::MediaStorage::SecondaryCaptureImageStorage);
  }
};

bool begins_stream(std::string_view bytes) {
  using namespace std::string_view_literals;
  return bytes.starts_with("\xFF\xD8\xFF"sv) ||      // JPEG, JPEG-LS
         bytes.starts_with("\xFF\x4F\xFF\x51"sv) ||  // JPEG 2000
         bytes.starts_with("\0\0\0\x0CjP  "sv);      // with boxes of a file
}

// Joins the fragments of each frame: of several frames, GDCM takes each fragment for a frame.
void join_fragments(std::size_t frames, gdcm::Bitmap& pixels) {
  const gdcm::SequenceOfFragments* const fragments =
      pixels.GetDataElement().GetSequenceOfFragments();
  if (fragments == nullptr || fragments->GetNumberOfFragments() <= frames || frames == 1) return;
  std::vector<std::string> streams;
  for (std::size_t i = 0; i < fragments->GetNumberOfFragments(); ++i) {
    const gdcm::ByteValue* const bytes = fragments->GetFragment(i).GetByteValue();
    if (bytes == nullptr) continue;
    const std::string_view fragment(bytes->GetPointer(), bytes->GetLength());
    if (streams.empty() || begins_stream(fragment)) streams.emplace_back();
    streams.back() += fragment;
  }
  if (streams.size() != frames) return;
  gdcm::SmartPointer<gdcm::SequenceOfFragments> joined = new gdcm::SequenceOfFragments;
  for (const std::string& stream : streams) {
    gdcm::Fragment fragment;
    fragment.SetByteValue(stream.data(), static_cast<std::uint32_t>(stream.size()));
    joined->AddFragment(fragment);
  }
  gdcm::DataElement element = pixels.GetDataElement();
  element.SetValue(*joined);
  pixels.SetDataElement(element);
}

// Interleaves the components of frames that are stored as planes.
void interleave(const DicomImage& image, std::vector<std::byte>& pixels) {
  const auto planes = static_cast<std::size_t>(image.components);
  const std::size_t width = bytes_of(image.type);
  const std::size_t count = image.frame_bytes() / width / planes;
  const std::vector<std::byte> stored = pixels;
  for (std::size_t begin = 0; begin < stored.size(); begin += image.frame_bytes()) {
    for (std::size_t i = 0; i < count * planes; ++i) {
      const std::size_t from = i % planes * count + i / planes;
      std::memcpy(pixels.data() + begin + i * width, stored.data() + begin + from * width, width);
    }
  }
}

}  // namespace

std::span<const std::byte> DicomFrames::samples(const DicomImage& image) {
  const std::size_t bytes = image.frame_bytes();
  const auto frame = static_cast<std::size_t>(image.frame);
  const std::size_t first_bit = frame * bytes;  // If samples are bits.
  if (image.pixels_at && !image.tile) {
    const InputFile file(image.file);
    if (!image.has_bits) {
      one_.resize(bytes);
      file.read(*image.pixels_at + frame * bytes, one_);
      take_stored_bits(image, one_);
      return one_;
    }
    std::vector<std::byte> packed((first_bit + bytes + 7) / 8 - first_bit / 8);
    file.read(*image.pixels_at + first_bit / 8, packed);
    return unpacked_bits(packed, first_bit % 8, bytes);
  }
  load(image);
  if (image.tile) return tile_of_mosaic(image);
  if (image.has_bits) return unpacked_bits(pixels_, first_bit, bytes);
  return std::span<const std::byte>(pixels_).subspan(frame * bytes, bytes);
}

// The first bit is the lowest of a byte.
std::span<const std::byte> DicomFrames::unpacked_bits(std::span<const std::byte> bytes,
                                                      std::size_t first_bit, std::size_t count) {
  one_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t bit = first_bit + i;
    one_[i] = bytes[bit / 8] >> (bit % 8) & std::byte{1};
  }
  return one_;
}

std::span<const std::byte> DicomFrames::tile_of_mosaic(const DicomImage& image) {
  const DicomTile& tile = *image.tile;
  const std::size_t pixel =
      image.frame_bytes() / static_cast<std::size_t>(image.size[0] * image.size[1]);
  const std::size_t row_bytes = static_cast<std::size_t>(image.size[0]) * pixel;
  one_.resize(image.frame_bytes());
  for (std::int64_t row = 0; row < image.size[1]; ++row) {
    const std::int64_t at = (tile.first_row + row) * tile.mosaic_columns + tile.first_column;
    std::memcpy(one_.data() + static_cast<std::size_t>(row) * row_bytes,
                pixels_.data() + static_cast<std::size_t>(at) * pixel, row_bytes);
  }
  return one_;
}

void DicomFrames::load(const DicomImage& image) {
  if (loaded_ == image.file) return;
  loaded_.clear();
  if (image.element != 0x0010 || image.has_bits) {
    load_element(image);
  } else {
    load_by_gdcm(image);
  }
  take_stored_bits(image, pixels_);
  loaded_ = image.file;
}

void DicomFrames::load_by_gdcm(const DicomImage& image) {
  PixelReader reader;
  reader.SetFileName(image.file.c_str());
  if (!reader.read_pixels()) {
    fail_reading(image.file, "GDCM cannot read its image", kSaveUncompressed);
  }
  gdcm::Bitmap& pixels = reader.GetPixmap();
  join_fragments(image.tile ? 1 : static_cast<std::size_t>(image.frames), pixels);
  if (image.unused_bits > 0 && !image.is_jpeg) {  // GDCM would drop the highest bits.
    gdcm::PixelFormat all_bits = pixels.GetPixelFormat();
    all_bits.SetBitsStored(all_bits.GetBitsAllocated());
    pixels.SetPixelFormat(all_bits);
  }
  const std::size_t needed = image.file_bytes();
  if (pixels.GetBufferLength() != needed || dicom_type(pixels.GetPixelFormat()) != image.type) {
    fail_reading(image.file,
                 "its image has " + std::to_string(pixels.GetBufferLength()) +
                     " bytes, but its header declares " + std::to_string(needed),
                 "Decompress it first, for example with gdcmconv --raw, or save it again");
  }
  pixels_.resize(needed);
  if (!pixels.GetBuffer(reinterpret_cast<char*>(pixels_.data()))) {
    fail_reading(image.file, "GDCM cannot decompress its pixels", kSaveUncompressed);
  }
  if (image.has_planes && !image.is_jpeg) interleave(image, pixels_);
}

// Loads an element that GDCM takes for no image.
void DicomFrames::load_element(const DicomImage& image) {
  gdcm::Reader reader;
  reader.SetFileName(image.file.c_str());
  const gdcm::Tag tag(0x7FE0, image.element);
  const bool is_read = reader.Read() && reader.GetFile().GetDataSet().FindDataElement(tag);
  const gdcm::ByteValue* const bytes =
      is_read ? reader.GetFile().GetDataSet().GetDataElement(tag).GetByteValue() : nullptr;
  const std::size_t needed = image.has_bits ? (image.file_bytes() + 7) / 8 : image.file_bytes();
  if (bytes == nullptr || bytes->GetLength() < needed) {
    fail_reading(image.file, "its pixels are missing, too short or compressed", kSaveUncompressed);
  }
  pixels_.resize(needed);
  std::memcpy(pixels_.data(), bytes->GetPointer(), needed);
}

}  // namespace multitetra
