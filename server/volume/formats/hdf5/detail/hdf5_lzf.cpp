#include "server/volume/formats/hdf5/detail/hdf5_lzf.hpp"

#include <hdf5.h>
#include <lzf.h>

#include <cstdlib>

namespace multitetra {
namespace {

// A libhdf5 filter. `values[2]` is the size of a chunk; `buffer` was allocated by malloc().
std::size_t lzf_filter(unsigned flags, std::size_t count, const unsigned* values, std::size_t bytes,
                       std::size_t* buffer_bytes, void** buffer) {
  if ((flags & H5Z_FLAG_REVERSE) == 0 || count < 3 || values[2] == 0) return 0;
  const unsigned room = values[2];
  void* const plain = std::malloc(room);
  if (plain == nullptr) return 0;
  // A short result would leave the rest of the chunk uninitialized.
  if (bytes > ~0u || lzf_decompress(*buffer, static_cast<unsigned>(bytes), plain, room) != room) {
    std::free(plain);
    return 0;
  }
  std::free(*buffer);
  *buffer = plain;
  *buffer_bytes = room;
  return room;
}

}  // namespace

void register_hdf5_lzf() {
  static const H5Z_class2_t kClass = {.version = H5Z_CLASS_T_VERS,
                                      .id = kHdf5Lzf,
                                      .encoder_present = 0,
                                      .decoder_present = 1,
                                      .name = "lzf",
                                      .can_apply = nullptr,
                                      .set_local = nullptr,
                                      .filter = &lzf_filter};
  H5Zregister(&kClass);
}

}  // namespace multitetra
