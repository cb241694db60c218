#include "server/volume/formats/hdf5/detail/hdf5_chunks.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <span>

#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/hdf5/detail/hdf5_object.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kChecksumBytes = 4;

// Unpacks without storing. Returns whether exactly `expected` bytes come out.
bool inflates_to(std::span<const std::byte> packed, std::size_t expected) {
  z_stream stream{};
  if (packed.size() > std::numeric_limits<uInt>::max() || inflateInit(&stream) != Z_OK)
    return false;
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  std::array<Bytef, 65536> plain;
  int state = Z_OK;
  while (state == Z_OK && stream.total_out <= expected) {
    stream.next_out = plain.data();
    stream.avail_out = static_cast<uInt>(plain.size());
    state = inflate(&stream, Z_NO_FLUSH);
  }
  const bool is_whole = state == Z_STREAM_END && stream.total_out == expected;
  inflateEnd(&stream);
  return is_whole;
}

// libhdf5 stores the unpacked size first, little-endian.
bool szip_holds(std::span<const std::byte> packed, std::size_t expected) {
  if (packed.size() < 4) return false;
  std::size_t size = 0;
  for (std::size_t i = 0; i < 4; ++i) size |= std::to_integer<std::size_t>(packed[i]) << (8 * i);
  return size == expected;
}

}  // namespace

Hdf5ChunkSizes::Hdf5ChunkSizes(const std::filesystem::path& file, hid_t dataset)
    : file_(file), dims_(hdf5_dims(dataset)) {
  const Hdf5Id creation(H5Dget_create_plist(dataset), &H5Pclose);
  if (H5Pget_layout(creation.get()) != H5D_CHUNKED) return;
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
    std::size_t values = 0;
    const H5Z_filter_t id = H5Pget_filter2(creation.get(), static_cast<unsigned>(i), &flags,
                                           &values, nullptr, 0, nullptr, nullptr);
    Filter filter{.packing = Packing::kOther, .is_checksum = id == H5Z_FILTER_FLETCHER32};
    if (id == H5Z_FILTER_SHUFFLE || filter.is_checksum) filter.packing = Packing::kPlain;
    if (id == H5Z_FILTER_DEFLATE) filter.packing = Packing::kDeflate;
    if (id == H5Z_FILTER_SZIP) filter.packing = Packing::kSzip;
    filters_.push_back(filter);
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

void Hdf5ChunkSizes::require_whole(hid_t dataset, const std::vector<hsize_t>& start,
                                   const std::vector<hsize_t>& extent) {
  if (chunk_.empty()) return;
  const std::size_t rank = dims_.size();
  std::vector<hsize_t> first(rank);
  std::vector<hsize_t> end(rank);
  for (std::size_t d = 0; d < rank; ++d) {
    first[d] = start[d] / chunk_[d];
    end[d] = (start[d] + extent[d] - 1) / chunk_[d] + 1;
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

void Hdf5ChunkSizes::require_whole_chunk(hid_t dataset, const std::vector<hsize_t>& at) {
  hsize_t bytes = 0;
  // Chunks that were never written have the fill value.
  if (H5Dget_chunk_storage_size(dataset, at.data(), &bytes) < 0 || bytes == 0) return;
  if (bytes > file_bytes_) fail(at);
  std::vector<std::byte> packed(static_cast<std::size_t>(bytes));
  unsigned skipped = 0;
  if (H5Dread_chunk(dataset, H5P_DEFAULT, at.data(), &skipped, packed.data()) < 0) fail(at);
  if (are_partial_chunks_plain_) {
    for (std::size_t d = 0; d < at.size(); ++d) {
      if (at[d] + chunk_[d] > dims_[d]) skipped = ~0u;
    }
  }
  if (!is_whole(packed, skipped)) fail(at);
}

bool Hdf5ChunkSizes::is_whole(const std::vector<std::byte>& packed, unsigned skipped) const {
  std::span<const std::byte> left(packed);
  std::size_t expected = chunk_bytes_;  // Size after unpacking the current filter.
  const auto is_used = [&](std::size_t i) { return i >= 32 || ((skipped >> i) & 1) == 0; };
  for (std::size_t i = filters_.size(); i-- > 0;) {
    if (!is_used(i)) continue;
    if (filters_[i].packing == Packing::kOther) return true;
    if (filters_[i].is_checksum) {
      if (left.size() < kChecksumBytes) return false;
      left = left.first(left.size() - kChecksumBytes);
    }
    if (filters_[i].packing == Packing::kPlain) continue;
    for (std::size_t inner = 0; inner < i; ++inner) {
      if (!is_used(inner)) continue;
      if (filters_[inner].packing != Packing::kPlain) return true;
      if (filters_[inner].is_checksum) expected += kChecksumBytes;
    }
    return filters_[i].packing == Packing::kDeflate ? inflates_to(left, expected)
                                                    : szip_holds(left, expected);
  }
  return left.size() == expected;
}

void Hdf5ChunkSizes::fail(const std::vector<hsize_t>& at) const {
  std::string place;
  for (const hsize_t index : at) place += (place.empty() ? " at " : ", ") + std::to_string(index);
  fail_damaged(file_, "its chunk" + place + " does not have the " + std::to_string(chunk_bytes_) +
                          " bytes that its shape requires");
}

}  // namespace multitetra
