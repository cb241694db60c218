#include "server/volume/formats/hdf5/detail/hdf5_chunks.hpp"

#include <libaec.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>

#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/hdf5/detail/hdf5_lzf.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

using Bytes = std::vector<std::byte>;

constexpr std::size_t kChecksumBytes = 4;
constexpr std::size_t kScaleOffsetHeaderBytes = 21;

std::uint32_t little_endian(const Bytes& bytes) {
  std::uint32_t number = 0;
  for (unsigned i = 0; i < 4; ++i) number |= std::to_integer<std::uint32_t>(bytes[i]) << (8 * i);
  return number;
}

std::size_t bytes_of_bits(std::uint64_t bits) { return static_cast<std::size_t>((bits + 7) / 8); }

// Returns the unpacked size, which libhdf5 stores first; nullopt if that is above `most` or the
// data end before. libhdf5 leaves what is missing uninitialized. `values` has flags, the samples of
// a block, bits, and the samples of a line; lines are padded to whole blocks.
std::optional<std::size_t> szip_size(const Bytes& packed, const std::vector<unsigned>& values,
                                     std::size_t most) {
  constexpr unsigned kPreprocessed = 32;
  constexpr unsigned kBigEndian = 16;
  if (packed.size() < 4 || values.size() < 4 || values[1] == 0 || values[3] < values[1]) {
    return std::nullopt;
  }
  const std::size_t size = little_endian(packed);
  const bool is_bytewise = values[2] == 32 || values[2] == 64;
  aec_stream stream{};
  stream.bits_per_sample = is_bytewise ? 8 : values[2];
  stream.block_size = values[1];
  stream.rsi = (values[3] - 1) / values[1] + 1;
  stream.flags = ((values[0] & kBigEndian) != 0 ? AEC_DATA_MSB : 0U) |
                 ((values[0] & kPreprocessed) != 0 ? AEC_DATA_PREPROCESS : 0U);
  const std::size_t sample = stream.bits_per_sample > 16 ? 4 : stream.bits_per_sample > 8 ? 2 : 1;
  const std::size_t lines = (size / sample + values[3] - 1) / values[3];
  if (size > most || stream.rsi > most / values[1]) return std::nullopt;
  const bool is_padded = values[3] % values[1] != 0;
  Bytes plain(is_padded ? lines * stream.rsi * values[1] * sample : size);
  stream.next_in = reinterpret_cast<const unsigned char*>(packed.data() + 4);
  stream.avail_in = packed.size() - 4;
  stream.next_out = reinterpret_cast<unsigned char*>(plain.data());
  stream.avail_out = plain.size();
  const int state = aec_buffer_decode(&stream);
  return state == AEC_OK && stream.total_out == plain.size() ? std::optional(size) : std::nullopt;
}

// Returns the unpacked size; nullopt if the samples need more bytes than there are. `values` has
// the flag of plain data, the number of samples, their class, bytes, byte order and bits.
std::optional<std::size_t> nbit_size(const Bytes& packed, const std::vector<unsigned>& values) {
  constexpr unsigned kAtomicClass = 1;
  if (values.size() > 1 && values[1] != 0) return packed.size();
  if (values.size() < 8 || values[3] != kAtomicClass) return std::nullopt;
  const std::uint64_t bits = std::uint64_t{values[2]} * values[6];
  if (packed.size() < bytes_of_bits(bits)) return std::nullopt;
  return std::size_t{values[2]} * values[4];
}

// Returns the unpacked size of scaled samples. `values` has the kind and a factor, the number of
// samples, their class and bytes. The data begin with the bits of a sample.
std::optional<std::size_t> scale_offset_size(const Bytes& packed,
                                             const std::vector<unsigned>& values) {
  if (values.size() < 5) return std::nullopt;
  const unsigned most_bits = 8 * values[4];
  if (values[0] == H5Z_SO_INT && values[1] == most_bits) return packed.size();
  if (packed.size() < kScaleOffsetHeaderBytes) return std::nullopt;
  const std::uint32_t bits = little_endian(packed);
  const std::size_t needed = bytes_of_bits(std::uint64_t{values[2]} * bits);
  if (bits > most_bits || packed.size() - kScaleOffsetHeaderBytes < needed) return std::nullopt;
  return std::size_t{values[2]} * values[4];
}

// The bytes that no whole sample has come last, unchanged.
Bytes unshuffled(const Bytes& bytes, std::size_t sample_bytes) {
  Bytes plain = bytes;
  const std::size_t samples = sample_bytes == 0 ? 0 : bytes.size() / sample_bytes;
  for (std::size_t i = 0; i < samples; ++i) {
    for (std::size_t byte = 0; byte < sample_bytes; ++byte) {
      plain[i * sample_bytes + byte] = bytes[byte * samples + i];
    }
  }
  return plain;
}

// Returns nullopt if they have no sample in common.
std::optional<Hdf5Box> common_part(const Hdf5Box& a, const Hdf5Box& b) {
  Hdf5Box part = a;
  for (std::size_t d = 0; d < a.start.size(); ++d) {
    part.start[d] = std::max(a.start[d], b.start[d]);
    const hsize_t end = std::min(a.start[d] + a.extent[d], b.start[d] + b.extent[d]);
    if (part.start[d] >= end) return std::nullopt;
    part.extent[d] = end - part.start[d];
  }
  return part;
}

}  // namespace

Hdf5ChunkSizes::Hdf5ChunkSizes(fs::path file, hid_t dataset, bool allow_external_files)
    : file_(std::move(file)),
      allow_external_files_(allow_external_files),
      dims_(hdf5_dims(dataset)) {
  const Hdf5Id creation(H5Dget_create_plist(dataset), &H5Pclose);
  const H5D_layout_t layout = H5Pget_layout(creation.get());
  if (layout == H5D_VIRTUAL) {
    for (Hdf5Mapping& mapping : hdf5_mappings(file_, dataset, allow_external_files)) {
      sources_.push_back({.mapping = std::move(mapping)});
    }
  }
  const bool is_external = H5Pget_external_count(creation.get()) > 0;
  if (layout == H5D_COMPACT || (layout == H5D_CONTIGUOUS && !is_external)) {
    const hsize_t stored = H5Dget_storage_size(dataset);  // 0: never written.
    if (stored < hdf5_bytes(dataset) && (stored > 0 || layout == H5D_COMPACT)) {
      fail_damaged(file_, "its dataset has fewer bytes than its shape requires");
    }
  }
  if (layout != H5D_CHUNKED) return;
  const Hdf5Id type(H5Dget_type(dataset), &H5Tclose);
  std::vector<hsize_t> chunk(dims_.size());
  H5Pget_chunk(creation.get(), static_cast<int>(chunk.size()), chunk.data());
  chunk_bytes_ = H5Tget_size(type.get());
  for (const hsize_t length : chunk) chunk_bytes_ *= static_cast<std::size_t>(length);
  unsigned options = 0;
  H5Pget_chunk_opts(creation.get(), &options);
  are_partial_chunks_plain_ = (options & H5D_CHUNK_DONT_FILTER_PARTIAL_CHUNKS) != 0;
  const int filters = H5Pget_nfilters(creation.get());
  for (int i = 0; i < filters; ++i) {
    unsigned flags = 0;
    std::array<unsigned, 32> values{};
    std::size_t count = values.size();
    const H5Z_filter_t id = H5Pget_filter2(creation.get(), static_cast<unsigned>(i), &flags, &count,
                                           values.data(), 0, nullptr, nullptr);
    const auto end = values.begin() + static_cast<std::ptrdiff_t>(std::min(count, values.size()));
    filters_.push_back({.id = id, .values = {values.begin(), end}});
  }
  if (!filters_.empty()) {
    chunk_ = std::move(chunk);
    const Hdf5Id own_file(H5Iget_file_id(dataset), &H5Fclose);
    if (H5Fget_filesize(own_file.get(), &file_bytes_) < 0) fail({});
    return;
  }
  // For chunks without filters, libhdf5 returns only the sum of their sizes.
  hsize_t chunks = 0;
  const Hdf5Id space(H5Dget_space(dataset), &H5Sclose);
  if (H5Dget_num_chunks(dataset, space.get(), &chunks) < 0 ||
      H5Dget_storage_size(dataset) != chunks * chunk_bytes_) {
    fail({});
  }
}

void Hdf5ChunkSizes::require_whole(hid_t dataset, const Hdf5Box& box) {
  for (Source& source : sources_) {
    if (source.is_checked || !common_part(box, source.mapping.in_virtual)) continue;
    require_whole_source(source.mapping);
    source.is_checked = true;
  }
  if (chunk_.empty()) return;
  const std::size_t rank = dims_.size();
  std::vector<hsize_t> first(rank);
  std::vector<hsize_t> end(rank);
  for (std::size_t d = 0; d < rank; ++d) {
    first[d] = box.start[d] / chunk_[d];
    end[d] = (box.start[d] + box.extent[d] - 1) / chunk_[d] + 1;
  }
  if (rank >= 3) {
    const std::size_t d = rank - 3;
    if (first[d] + 1 == checked_layers_) ++first[d];
    checked_layers_ = end[d];
    if (first[d] == end[d]) return;
  }
  std::vector<hsize_t> at = first;
  std::vector<hsize_t> offset(rank);
  for (std::size_t d = 0; d < rank;) {
    for (std::size_t i = 0; i < rank; ++i) offset[i] = at[i] * chunk_[i];
    require_whole_chunk(dataset, offset);
    for (d = 0; d < rank && ++at[d] == end[d]; ++d) at[d] = first[d];
  }
}

// Checks all that a source supplies.
void Hdf5ChunkSizes::require_whole_source(const Hdf5Mapping& mapping) const {
  const Hdf5Id file = open_hdf5_file(mapping.file);
  const std::optional<Hdf5Id> dataset =
      open_hdf5_dataset(mapping.file, file.get(), mapping.dataset, allow_external_files_);
  if (!dataset) return;  // Has the fill value.
  Hdf5ChunkSizes sizes(mapping.file, dataset->get(), allow_external_files_);
  const Hdf5Box whole = whole_box(hdf5_dims(dataset->get()));
  const bool has_bounds = mapping.in_source.start.size() == whole.start.size();
  const std::optional<Hdf5Box> needed = common_part(has_bounds ? mapping.in_source : whole, whole);
  if (needed) sizes.require_whole(dataset->get(), *needed);
}

void Hdf5ChunkSizes::require_whole_chunk(hid_t dataset, const std::vector<hsize_t>& at) {
  hsize_t bytes = 0;
  // Chunks that were never written have the fill value.
  if (H5Dget_chunk_storage_size(dataset, at.data(), &bytes) < 0 || bytes == 0) return;
  if (bytes > file_bytes_) fail(at);
  Bytes chunk(static_cast<std::size_t>(bytes));
  unsigned skipped = 0;
  if (H5Dread_chunk(dataset, H5P_DEFAULT, at.data(), &skipped, chunk.data()) < 0) fail(at);
  if (are_partial_chunks_plain_) {
    for (std::size_t d = 0; d < at.size(); ++d) {
      if (at[d] + chunk_[d] > dims_[d]) skipped = ~0u;
    }
  }
  if (!is_whole(std::move(chunk), skipped)) fail(at);
}

bool Hdf5ChunkSizes::is_whole(Bytes chunk, unsigned skipped) const {
  bool has_contents = true;
  for (std::size_t i = filters_.size(); i-- > 0;) {
    const H5Z_filter_t id = filters_[i].id;
    if (i < 32 && ((skipped >> i) & 1) != 0) continue;
    const bool is_stream = id == H5Z_FILTER_DEFLATE;
    if ((is_stream || id == H5Z_FILTER_SZIP || id == H5Z_FILTER_SCALEOFFSET) && !has_contents)
      refuse(filters_[i]);
    if (!unpack(filters_[i], /*needs_contents=*/i > 0, chunk)) return false;
    has_contents &= is_stream || id == H5Z_FILTER_SHUFFLE || id == H5Z_FILTER_FLETCHER32;
  }
  return chunk.size() == chunk_bytes_;
}

bool Hdf5ChunkSizes::unpack(const Filter& filter, bool needs_contents, Bytes& bytes) const {
  // The maximum size of data for a second filter.
  const std::size_t most = chunk_bytes_ + chunk_bytes_ / 8 + 4096;
  const std::vector<unsigned>& values = filter.values;
  const auto has_size = [&](std::optional<std::size_t> size) {
    if (size && *size <= most) bytes.resize(*size);
    return size && *size <= most;
  };
  switch (filter.id) {
    case H5Z_FILTER_DEFLATE: {
      // As libhdf5 does, ignores what follows the stream.
      Bytes plain(most);
      uLongf size = most;
      uLong packed = bytes.size();
      const auto* data = reinterpret_cast<const Bytef*>(bytes.data());
      auto* unpacked = reinterpret_cast<Bytef*>(plain.data());
      if (uncompress2(unpacked, &size, data, &packed) != Z_OK) return false;
      plain.resize(size);
      bytes = std::move(plain);
      return true;
    }
    case H5Z_FILTER_SZIP:
      return has_size(szip_size(bytes, values, most));
    case H5Z_FILTER_SHUFFLE:
      if (needs_contents && !values.empty()) bytes = unshuffled(bytes, values[0]);
      return true;
    case H5Z_FILTER_FLETCHER32:
      return bytes.size() >= kChecksumBytes && has_size(bytes.size() - kChecksumBytes);
    case H5Z_FILTER_NBIT:
      return has_size(nbit_size(bytes, values));
    case H5Z_FILTER_SCALEOFFSET:
      return has_size(scale_offset_size(bytes, values));
    case kHdf5Lzf:  // Our filter refuses other sizes.
      return values.size() > 2 && has_size(values[2]);
    default:
      refuse(filter);
  }
}

void Hdf5ChunkSizes::refuse(const Filter& filter) const {
  fail_reading(file_,
               "its chunks are packed with HDF5 filter " + std::to_string(filter.id) +
                   ", whose sizes cannot be checked",
               "Repack the file, as with h5repack -f GZIP=4");
}

void Hdf5ChunkSizes::fail(const std::vector<hsize_t>& at) const {
  std::string place;
  for (const hsize_t index : at) place += (place.empty() ? " at " : ", ") + std::to_string(index);
  fail_damaged(file_, "its chunk" + place + " does not have the " + std::to_string(chunk_bytes_) +
                          " bytes that its shape requires");
}

}  // namespace multitetra
