#include "server/volume/formats/hdf5/detail/hdf5_lzf.hpp"

#include <hdf5.h>

#include <cstdlib>
#include <cstring>

namespace multitetra {
namespace {

// A libhdf5 filter. `values[2]` is the size of a chunk; `buffer` was allocated by malloc().
std::size_t lzf_filter(unsigned flags, std::size_t count, const unsigned* values, std::size_t bytes,
                       std::size_t* buffer_bytes, void** buffer) {
  if ((flags & H5Z_FLAG_REVERSE) == 0 || count < 3 || values[2] == 0) return 0;
  const std::size_t room = values[2];
  auto* const plain = static_cast<unsigned char*>(std::malloc(room));
  if (plain == nullptr) return 0;
  const std::size_t done =
      unpack_lzf(static_cast<const unsigned char*>(*buffer), bytes, plain, room);
  if (done != room) {  // A short result would leave the rest of the chunk uninitialized.
    std::free(plain);
    return 0;
  }
  std::free(*buffer);
  *buffer = plain;
  *buffer_bytes = room;
  return done;
}

}  // namespace

// A byte below 32 precedes that many literals plus one; others give a length and a distance.
std::size_t unpack_lzf(const unsigned char* in, std::size_t size, unsigned char* out,
                       std::size_t room) {
  std::size_t at = 0;
  std::size_t done = 0;
  while (at < size) {
    const std::size_t control = in[at++];
    if (control < 32) {
      const std::size_t count = control + 1;
      if (count > size - at || count > room - done) return 0;
      std::memcpy(out + done, in + at, count);
      at += count;
      done += count;
      continue;
    }
    std::size_t count = control >> 5;
    if (count == 7) {
      if (at == size) return 0;
      count += in[at++];
    }
    count += 2;
    if (at == size) return 0;
    const std::size_t back = ((control & 31) << 8) + in[at++] + 1;
    if (back > done || count > room - done) return 0;
    for (std::size_t i = 0; i < count; ++i, ++done) out[done] = out[done - back];
  }
  return done;
}

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
