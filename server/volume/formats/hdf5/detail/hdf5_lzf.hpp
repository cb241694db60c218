// LZF in HDF5: the filter that h5py registers (32000).
#pragma once

#include <cstddef>

namespace multitetra {

inline constexpr int kHdf5Lzf = 32000;

// Unpacks `size` bytes into at most `room` bytes. Returns their number, or 0 if the packed bytes
// are damaged or unpack to more.
[[nodiscard]] std::size_t unpack_lzf(const unsigned char* in, std::size_t size, unsigned char* out,
                                     std::size_t room);

// Registers the filter with this process's libhdf5. May be called repeatedly.
void register_hdf5_lzf();

}  // namespace multitetra
