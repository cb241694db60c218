// LZF in HDF5: the filter that h5py registers for itself (32000).
#pragma once

namespace multitetra {

// Makes libhdf5 of this process unpack chunks of that filter. May be called again.
void register_hdf5_lzf();

}  // namespace multitetra
