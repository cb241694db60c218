// Checks the unpacked sizes of a dataset's chunks. libhdf5 accepts chunks with too few bytes and
// leaves the other samples uninitialized.
#pragma once

#include <hdf5.h>

#include <cstddef>
#include <filesystem>
#include <vector>

namespace multitetra {

// Checks chunks before libhdf5 reads them: those without filters, and those whose outermost filter
// besides shuffling and checksums is deflate or szip. The LZF filter checks its own; sources of
// virtual datasets are not checked.
class Hdf5ChunkSizes {
 public:
  // Checks datasets without filters at once. Throws VolumeFileError.
  Hdf5ChunkSizes(const std::filesystem::path& file, hid_t dataset);

  // Checks all chunks of the box at `start`, except for the layer (along the dimension of the
  // slices) in which the previous call ended. Consecutive calls may differ along that dimension
  // only. Throws VolumeFileError.
  void require_whole(hid_t dataset, const std::vector<hsize_t>& start,
                     const std::vector<hsize_t>& extent);

 private:
  enum class Packing { kPlain, kDeflate, kSzip, kOther };
  struct Filter {
    Packing packing;
    bool is_checksum;
  };

  void require_whole_chunk(hid_t dataset, const std::vector<hsize_t>& at);
  [[nodiscard]] bool is_whole(const std::vector<std::byte>& packed, unsigned skipped) const;
  [[noreturn]] void fail(const std::vector<hsize_t>& at) const;

  std::filesystem::path file_;
  std::vector<hsize_t> dims_;
  std::vector<hsize_t> chunk_;   // Empty unless the dataset has chunks with filters.
  std::vector<Filter> filters_;  // In the order of writing.
  std::size_t chunk_bytes_ = 0;
  hsize_t file_bytes_ = 0;
  bool are_partial_chunks_plain_ = false;
  hsize_t checked_layers_ = 0;  // Along the dimension of the slices.
};

}  // namespace multitetra
