// LZF in HDF5: the filter that h5py registers (32000).
#pragma once

namespace multitetra {

inline constexpr int kHdf5Lzf = 32000;

// Registers the filter with this process's libhdf5. May be called repeatedly.
void register_hdf5_lzf();

}  // namespace multitetra
