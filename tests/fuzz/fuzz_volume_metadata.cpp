// Metadata of volumes in formats that we parse ourselves: the XML of .vti files, the metadata of
// Zarr 2, Zarr 3 and N5, chunks with such metadata, and the descriptions by ImageJ and OME-XML in
// TIFF files. The first byte selects the kind; of a chunk, the text up to the first zero is the
// array's metadata.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "server/volume/formats/detail/tiff_description.hpp"
#include "server/volume/formats/vtk/detail/vti_header.hpp"
#include "server/volume/formats/zarr/detail/chunked_array.hpp"
#include "tests/fuzz/require.hpp"

namespace multitetra {
namespace {

void parse_xml(std::string_view text, std::size_t portion) {
  const auto next = [&] {
    const std::string_view bytes = text.substr(0, portion);
    text.remove_prefix(bytes.size());
    return bytes;
  };
  const auto header = parse_vti(next);
  if (!header) return;
  for (const VtiArray& array : header->arrays) {
    require(array.components >= 1 && array.components <= kMaxComponents);
    if (array.format != VtiArray::Format::kAppended)
      require(array.begin <= array.end || array.end == 0);
  }
}

void decode(std::string_view text, Result<ArrayLayout> (*parse)(std::string_view)) {
  const std::size_t end = text.find('\0');
  const auto layout = parse(text.substr(0, end));
  if (!layout) return;
  require(layout->chunk.size() == layout->shape.size());
  require(layout->fill.size() == bytes_of(layout->type));
  (void)layout->key(std::vector<std::int64_t>(layout->shape.size(), 7));
  constexpr std::size_t kSmall = std::size_t{1} << 20;  // Larger ones only cost time.
  if (end == std::string_view::npos || layout->chunk_bytes() > kSmall) return;
  const auto stored = std::as_bytes(std::span(text.substr(end + 1)));
  if (const auto chunk = decode_chunk(*layout, stored)) {
    require(chunk->size() == layout->chunk_bytes());
  }
  if (layout->shards && shard_index_bytes(*layout) <= kSmall)
    (void)decode_shard_index(*layout, stored);
}

void check_pages(const Result<TiffDescription>& description) {
  if (!description) return;
  require(static_cast<std::int64_t>(description->pages.size()) ==
          description->slices * description->channels * description->times.count);
}

}  // namespace
}  // namespace multitetra

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multitetra;
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0] % 7) {
    case 0:
      parse_xml(text, 1 + size);
      break;
    case 1:
      parse_xml(text, 7);
      break;
    case 2:
      decode(text, &parse_zarr_2);
      break;
    case 3:
      decode(text, &parse_zarr_3);
      break;
    case 5:
      check_pages(parse_imagej_description(text));
      break;
    case 6:
      check_pages(parse_ome_description(text, 1));
      break;
    default:
      decode(text, &parse_n5);
  }
  return 0;
}
