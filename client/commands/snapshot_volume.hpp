// The samples of a dataset as a volume of a picture: options, and what is fetched.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/library/client.hpp"
#include "common/cli/command.hpp"
#include "common/picture/volume.hpp"

namespace multitetra {

struct VolumeArguments {
  std::string mode = "off";    // "off", "on" or "maximum".
  std::string opacities = {};  // "150:0,400:0.1"; empty: usual_opacities().
  std::vector<double> window =
      {};  // The values of the first and the last color; empty: usual_window().
  std::string map = "gray";
  bool is_unlit = false;
  std::uint64_t samples =
      std::uint64_t{1}
      << 26;  // At most; larger datasets are drawn from every 2nd, 4th ... along each axis.

  [[nodiscard]] bool is_shown() const { return mode != "off"; }
};

void add_volume_options(Command& command, VolumeArguments& arguments);

// Parses "150:0,400:0.1", as in addresses of the viewer: opacities from 0 to 1 of a layer one voxel
// thick, by ascending value. Returns kInvalidArgument for anything else.
[[nodiscard]] Result<std::vector<OpacityPoint>> parse_opacities(std::string_view text);

// Bone of computed tomography; a faint ramp over the usual window of other data.
[[nodiscard]] std::vector<OpacityPoint> usual_opacities(const DatasetInfo& info);
// The window of bone of computed tomography, the source's own, or that of most values: all but a
// hundredth that is lower and a two-hundredth that is higher, without a background of the lowest.
[[nodiscard]] DisplayWindow usual_window(const DatasetInfo& info);

// Returns kInvalidArgument, naming the option.
[[nodiscard]] Result<void> check(const VolumeArguments& arguments);

struct FetchedVolume {
  DrawnVolume drawn;
  std::uint64_t step = 1;  // Every so many samples along each axis.
};

// Fetches a volume, with arguments that check() accepts. `to_output` maps sample indices to the
// surfaces' coordinates.
[[nodiscard]] ClientResult<FetchedVolume> fetched_volume(const VolumeArguments& arguments,
                                                         Client& client, const DatasetInfo& info,
                                                         const Affine& to_output);

}  // namespace multitetra
