// Checks that the samples of a dataset are stored completely. libhdf5 reads chunks with too few
// bytes without an error: it leaves the other samples uninitialized, or takes bytes of other
// memory.
#pragma once

#include <hdf5.h>

#include <cstddef>
#include <filesystem>
#include <vector>

#include "server/volume/formats/hdf5/detail/hdf5_object.hpp"

namespace multitetra {

// Checks chunks before libhdf5 reads them, also those of the sources of virtual datasets. Refuses
// filters whose sizes it cannot check: all but deflate, szip, LZF, nbit, scale-offset, shuffle and
// Fletcher-32.
class Hdf5ChunkSizes {
 public:
  // Checks datasets without filters at once. Throws VolumeFileError.
  Hdf5ChunkSizes(std::filesystem::path file, hid_t dataset, bool allow_external_files);

  // Checks all chunks of the box, except for the layer (along the dimension of the slices) in which
  // the previous call ended. Consecutive calls may differ along that dimension only. Throws
  // VolumeFileError.
  void require_whole(hid_t dataset, const Hdf5Box& box);

 private:
  struct Filter {
    H5Z_filter_t id;
    std::vector<unsigned> values;
  };
  struct Source {
    Hdf5Mapping mapping;
    bool is_checked = false;
  };

  void require_whole_source(const Hdf5Mapping& mapping) const;
  void require_whole_chunk(hid_t dataset, const std::vector<hsize_t>& at);
  // Returns whether a chunk unpacks to its size. A set bit of `skipped` excludes a filter.
  [[nodiscard]] bool is_whole(std::vector<std::byte> chunk, unsigned skipped) const;
  // Replaces `bytes` by what a filter makes of them: their number, and with `needs_contents` also
  // their values, for deflate, shuffle and Fletcher-32. Returns false if there are too few.
  [[nodiscard]] bool unpack(const Filter& filter, bool needs_contents,
                            std::vector<std::byte>& bytes) const;
  [[noreturn]] void refuse(const Filter& filter) const;
  [[noreturn]] void fail(const std::vector<hsize_t>& at) const;

  std::filesystem::path file_;
  bool allow_external_files_;
  std::vector<hsize_t> dims_;
  std::vector<hsize_t> chunk_;   // Empty unless the dataset has chunks with filters.
  std::vector<Filter> filters_;  // In the order of writing.
  std::size_t chunk_bytes_ = 0;
  hsize_t file_bytes_ = 0;
  bool are_partial_chunks_plain_ = false;
  hsize_t checked_layers_ = 0;  // Along the dimension of the slices.
  std::vector<Source> sources_;
};

}  // namespace multitetra
