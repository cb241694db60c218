// LZF in HDF5: the filter that h5py registers for itself (32000).
#pragma once

#include <cstddef>

namespace multitetra {

// Unpacks `size` bytes into at most `room` ones. Returns how many came, 0 when the packed bytes are
// damaged or unpack to more.
[[nodiscard]] std::size_t unpack_lzf(const unsigned char* in, std::size_t size, unsigned char* out,
                                     std::size_t room);

// Makes libhdf5 of this process unpack chunks of that filter. May be called again.
void register_hdf5_lzf();

}  // namespace multitetra
