// The unpacked sizes of the chunks of a dataset. libhdf5 takes a chunk that holds fewer bytes than
// its shape needs; the other samples would be whatever the memory held.
#pragma once

#include <hdf5.h>

#include <cstddef>
#include <filesystem>
#include <vector>

namespace multitetra {

// Checks chunks before libhdf5 reads them: those without a filter, and those whose outermost filter
// besides shuffling and checksums is deflate or szip. LZF is checked by its filter. The sources of
// virtual datasets are not checked.
class Hdf5ChunkSizes {
 public:
  // Checks datasets without filters at once. Throws VolumeFileError.
  Hdf5ChunkSizes(const std::filesystem::path& file, hid_t dataset);

  // Checks all chunks that the box from `start` on touches, except those of the layer, along the
  // dimension of the slices, that the previous call has ended in. Requires that consecutive calls
  // differ along that dimension alone. Throws VolumeFileError.
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
  std::vector<hsize_t> chunk_;   // Empty: the dataset has no chunks with filters.
  std::vector<Filter> filters_;  // In the order of writing.
  std::size_t chunk_bytes_ = 0;
  hsize_t file_bytes_ = 0;
  bool are_partial_chunks_plain_ = false;
  hsize_t checked_layers_ = 0;  // Along the dimension of the slices.
};

}  // namespace multitetra
