// The two functions of each convention (see ArrayConvention).
#pragma once

#include <string>
#include <vector>

#include "server/volume/formats/arrays/conventions.hpp"

namespace multitetra {

#define MULTITETRA_CONVENTION(name)                                                        \
  std::vector<std::string> name##_arrays(const ArrayContainer& file, const VolumeChoice&); \
  bool describe_##name(const ArrayContainer& file, const std::string& array, ArrayMeaning&)

MULTITETRA_CONVENTION(axistags);         // ilastik, vigra: JSON in the attribute `axistags`.
MULTITETRA_CONVENTION(big_data_viewer);  // /t00000/s00/0/cells, and an XML file beside.
MULTITETRA_CONVENTION(dream3d);          // /DataContainers/NAME/_SIMPL_GEOMETRY.
MULTITETRA_CONVENTION(emd);              // Groups with `emd_group_type`.
MULTITETRA_CONVENTION(imaris);           // /DataSet/ResolutionLevel 0/TimePoint 0/Channel 0/Data.
MULTITETRA_CONVENTION(itk);              // /ITKImage/0/VoxelData.
MULTITETRA_CONVENTION(minc);             // MINC 1 (NetCDF) and 2 (/minc-2.0).
MULTITETRA_CONVENTION(nexus);            // Groups with NX_class NXdata.
MULTITETRA_CONVENTION(openpmd);          // Meshes with `axisLabels`.
MULTITETRA_CONVENTION(vtkhdf);           // /VTKHDF of Type ImageData.

#undef MULTITETRA_CONVENTION

}  // namespace multitetra
