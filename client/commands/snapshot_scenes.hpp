// The pictures of an order: one, or one for each time of a series; how their surfaces look, and
// what is fetched for them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/commands/connected_request.hpp"
#include "client/commands/snapshot_volume.hpp"
#include "common/image/color_map.hpp"
#include "common/picture/rasterizer.hpp"

namespace multitetra {

// What one picture shows: all of an order, or one time.
struct Scene {
  std::span<DatasetRequest> datasets;  // At least one.
  std::string picture_file;
};

// Sorts the datasets by time. Several times have a picture each, named like the first dataset's
// last part: flow_t0003.png.
[[nodiscard]] std::vector<Scene> scenes_of(const std::filesystem::path& picture,
                                           ConnectedRequests& connected);

// Returns opacity and color for each ordered surface: one for all, or one for each, colors as
// "#rrggbb". By default, a dataset's only surface has the dataset's color. Returns
// kInvalidArgument, naming the option.
[[nodiscard]] Result<std::vector<DrawnSurface>> appearances_of(
    const std::vector<double>& opacities, const std::vector<std::string>& surface_colors,
    std::span<const DatasetRequest> datasets);

// A fetched surface.
struct TakenSurface {
  OutputPart part;
  std::uint64_t bytes = 0;
  // The color scale of the vertices' values.
  std::optional<ColorScale> colors = {};

  [[nodiscard]] std::uint64_t triangles() const {
    return static_cast<std::uint64_t>(part.report.surface->topology.triangles);
  }
};

// All that was fetched, and timings.
struct Taken {
  std::vector<TakenSurface> surfaces;
  std::optional<FetchedVolume> volume = {};
  double fetch_seconds = 0;
  double draw_seconds = 0;

  [[nodiscard]] std::size_t empty_surfaces() const {
    return static_cast<std::size_t>(
        std::count_if(surfaces.begin(), surfaces.end(),
                      [](const TakenSurface& each) { return each.triangles() == 0; }));
  }
  [[nodiscard]] std::uint64_t triangles() const {
    std::uint64_t sum = 0;
    for (const TakenSurface& surface : surfaces) sum += surface.triangles();
    return sum;
  }
  [[nodiscard]] std::uint64_t bytes() const {
    std::uint64_t sum = 0;
    for (const TakenSurface& surface : surfaces) sum += surface.bytes;
    return volume ? sum + 4 * volume->drawn.values.size() : sum;
  }
};

// Maps sample indices to the coordinates of the pictures' surfaces.
[[nodiscard]] Affine index_to_output(const SurfaceArguments& arguments, const DatasetInfo& info);

// Fetches all surfaces of a scene, and the volume of its first dataset that is no label. Throws
// ExitError.
[[nodiscard]] Taken taken_from(const SurfaceOrder& order, const VolumeArguments& volume,
                               Client& client, const Scene& scene);

}  // namespace multitetra
