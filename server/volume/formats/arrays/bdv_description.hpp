// The XML files of BigDataViewer and BigStitcher: which views a dataset has, where its samples are
// stored, and how each view lies in the world.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/affine.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

struct BdvSetup {
  std::int64_t id = 0;
  std::string name = {};           // May be empty.
  std::vector<double> voxel = {};  // Lengths along x, y, z; empty if not stated.
  std::string unit = {};
};

struct BdvDescription {
  std::vector<BdvSetup> setups = {};
  // The map from sample indices to the world, by time and setup.
  std::map<std::pair<std::int64_t, std::int64_t>, Affine> registrations = {};
  std::vector<std::int64_t> times = {};  // Timepoints, ascending; at least one.
  std::string format = {};               // "bdv.hdf5", "bdv.n5" or another.
  // The file or folder with the samples, from the folder of the XML file on; not checked.
  std::filesystem::path samples = {};
};

// Parses an XML file. Throws VolumeFileError.
[[nodiscard]] BdvDescription bdv_description(const std::filesystem::path& xml);

// Returns the description beside the samples at `file`: the XML file of the same name, or the one
// in the same folder that refers to them. Returns nullopt if there is none.
[[nodiscard]] std::optional<BdvDescription> bdv_description_beside(
    const std::filesystem::path& file);

// Places a view whose samples are means of `factors` finest samples along each axis. Returns false
// if the description has no such view.
bool place_bdv_view(const BdvDescription& description, std::int64_t time, std::int64_t setup,
                    const std::array<double, 3>& factors, ImageHeader& header);

// Opens the samples of a description: a setup by choice.series, a timepoint by choice.time, a level
// by choice.level. Throws VolumeFileError.
[[nodiscard]] StoredVolume open_bdv(const std::filesystem::path& xml, const VolumeChoice& choice);
[[nodiscard]] bool is_bdv_xml(std::string_view beginning);

}  // namespace multitetra
