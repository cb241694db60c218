// Compressed samples in formats whose libraries read the rest: the pixel data of DICOM (raw, RLE,
// fragments of JPEG) and the elements before them, which must be complete or rejected. The first
// byte selects the kind.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/dicom/detail/dicom_meta.hpp"
#include "server/volume/formats/dicom/detail/dicom_pixels.hpp"
#include "server/volume/formats/stored_volume.hpp"
#include "tests/fuzz/require.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

// Four bytes give frames, samples and bits; the file follows, beginning with the element's head.
void check_pixels(std::string_view bytes, std::string_view syntax, const TemporaryFolder& folder) {
  constexpr std::size_t kSizes = 4;
  constexpr std::size_t kHead = 12;
  if (bytes.size() < kSizes) return;
  const auto number = [&](std::size_t at) {
    return std::uint64_t{static_cast<unsigned char>(bytes[at])};
  };
  const DicomPixels pixels{.offset = kHead,
                           .syntax = syntax,
                           .frames = 1 + number(0) % 8,
                           .frame_samples = 1 + number(1) + 256 * number(2),
                           .bits = number(3) % 2 == 0 ? 8U : 16U};
  const InputFile file(folder.file("v.dcm", bytes.substr(kSizes)));
  (void)check_dicom_pixels(file, pixels);
  // Unencapsulated data must have all of its bytes.
  if (bytes.substr(kSizes + 8, 4) != "\xFF\xFF\xFF\xFF") {
    require(file.size() >= kHead + pixels.frames * pixels.frame_samples * pixels.bits / 8);
  }
}

}  // namespace
}  // namespace multitetra

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multitetra;
  static const TemporaryFolder folder;
  if (size == 0) return 0;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  try {
    switch (data[0] % 8) {
      case 1:
        check_pixels(bytes, "1.2.840.10008.1.2.1", folder);
        break;
      case 2:
        check_pixels(bytes, "1.2.840.10008.1.2.2", folder);
        break;
      case 3:
        check_pixels(bytes, "1.2.840.10008.1.2.5", folder);
        break;
      case 4:
        check_pixels(bytes, "1.2.840.10008.1.2.4.70", folder);
        break;
      case 5: {
        const InputFile file(folder.file("d.dcm", bytes));
        const std::uint64_t meta_end = dicom_meta_end(file);
        require(meta_end < file.size());
        check_dicom_elements(file, meta_end);
        break;
      }
      default:
        break;
    }
  } catch (const VolumeFileError& refused) {
    require(std::string_view(refused.what()).starts_with("Cannot read '"));
  }
  return 0;
}
