#include "server/volume/formats/detail/header_bytes.hpp"

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

std::string unpacked_beginning(const InputFile& file, std::size_t count) {
  const Packing packing = UnpackedStream::packing_at(file, 0);
  if (packing != Packing::kGzip && packing != Packing::kBzip2) return file.beginning(count);
  std::string text(count, '\0');
  try {
    UnpackedStream stream(file, 0, packing);
    text.resize(stream.read_some(std::as_writable_bytes(std::span(text))));
  } catch (const VolumeFileError&) {
    text.clear();
  }
  return text;
}

}  // namespace multitetra
