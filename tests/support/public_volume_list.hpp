// The public volumes of the end-to-end tests, each with isovalues. They are not part of the
// project; ../shared/data/MANIFEST.md lists their sources.
#pragma once

#include <array>
#include <cctype>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/dataset/dataset_info.hpp"
#include "server/volume/volume_files.hpp"

namespace multitetra::testing {

struct PublicVolume {
  std::string file;
  std::vector<double> isovalues;
  bool is_large = false;
  std::optional<RawLayout> raw = std::nullopt;
};

inline void PrintTo(const PublicVolume& volume, std::ostream* out) { *out << volume.file; }

inline RawLayout bytes(std::array<std::int32_t, 3> dims) { return {.dims = dims}; }
inline RawLayout shorts_behind_6_bytes(std::array<std::int32_t, 3> dims) {
  return {.dims = dims, .type = StoredType::kU16, .header_bytes = 6};
}

inline std::vector<PublicVolume> public_volumes() {
  return {
      {.file = "cthead/CThead.nhdr", .isovalues = {500, 1200}, .is_large = true},
      {.file = "head_128x128x112.dat",
       .isovalues = {500, 1200},
       .raw = shorts_behind_6_bytes({128, 128, 112})},
      {.file = "lobster_120x120x34.dat",
       .isovalues = {500, 1500},
       .raw = shorts_behind_6_bytes({120, 120, 34})},
      {.file = "fuel_64x64x64_uint8.raw", .isovalues = {15, 60, 140}, .raw = bytes({64, 64, 64})},
      {.file = "neghip_64x64x64_uint8.raw", .isovalues = {30, 80, 150}, .raw = bytes({64, 64, 64})},
      {.file = "Bucky_32x32x32_uint8.raw", .isovalues = {60, 120, 170}, .raw = bytes({32, 32, 32})},
      {.file = "tooth_103x94x161_uint8.raw", .isovalues = {100, 195}, .raw = bytes({103, 94, 161})},
      {.file = "tooth16/tooth.nhdr", .isovalues = {510, 1000}},
      {.file = "engine/engine.mhd", .isovalues = {70, 180}, .is_large = true},
      {.file = "bonsai_small/bonsai_small.mhd", .isovalues = {40, 110}, .is_large = true},
      {.file = "headsq/quarter.nhdr", .isovalues = {500, 1150}},
      {.file = "stent.nrrd", .isovalues = {0.15, 0.45}, .is_large = true},
      {.file = "hydrogen.vtk", .isovalues = {0.02, 0.1, 0.4}},
      {.file = "ironProt.vtk", .isovalues = {30, 80, 150}},
      {.file = "MRI-Head_256x256x256.nrrd", .isovalues = {50, 125}, .is_large = true},
      {.file = "Iguana.nii.gz", .isovalues = {40, 120}, .is_large = true},
      {.file = "chris_t1.nii.gz", .isovalues = {50, 105}, .is_large = true},
      {.file = "avg152T1_RL_nifti.nii.gz", .isovalues = {100, 175}},
      {.file = "frogtissue/frogtissue.mhd", .isovalues = {0.5}, .is_large = true},
      {.file = "HeadMRVolume/HeadMRVolume.mhd", .isovalues = {25, 65}},
      {.file = "Brain_float/Brain.mhd", .isovalues = {25, 60}},
      {.file = "visible_female_head_512x512x234_HU.nrrd",
       .isovalues = {-300, 300},
       .is_large = true},
  };
}

inline std::string name_of_volume(const ::testing::TestParamInfo<PublicVolume>& parameter) {
  std::string name = parameter.param.file.substr(0, parameter.param.file.find_last_of('.'));
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  }
  return name;
}

// An error in voxels, and whether the mesh is simplified.
struct TestedError {
  double error = 0;
  bool simplify = false;
};

// Returns `errors` without simplification, then with it. Simplification takes ten times as long as
// everything else: all errors only if MULTITETRA_ALL_TESTS is set, otherwise one, on volumes of
// at most 64^3 samples.
inline std::vector<TestedError> tested_errors(const std::vector<double>& errors,
                                              const DatasetInfo& info) {
  std::vector<TestedError> all;
  for (const double error : errors) all.push_back({error, false});
  const std::int64_t samples = std::int64_t{info.dims[0]} * info.dims[1] * info.dims[2];
  if (std::getenv("MULTITETRA_ALL_TESTS") != nullptr) {
    for (const double error : {0.25, 0.5, 1.0, 2.0}) all.push_back({error, true});
  } else if (samples <= 64 * 64 * 64) {
    all.push_back({0.5, true});
  }
  return all;
}

// Returns why the volume is skipped, for GTEST_SKIP; nullopt if it is tested.
inline std::optional<std::string> why_skipped(const PublicVolume& volume) {
  if (!std::filesystem::exists(std::filesystem::path(MULTITETRA_PUBLIC_DATA) / volume.file)) {
    return "NOT TESTED: there is no public volume " + volume.file;
  }
  if (volume.is_large && std::getenv("MULTITETRA_ALL_TESTS") == nullptr) {
    return "NOT TESTED: " + volume.file + " is large; `bash tests/run.sh --all` takes it too";
  }
  return std::nullopt;
}

}  // namespace multitetra::testing
