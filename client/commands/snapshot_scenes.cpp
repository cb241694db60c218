#include "client/commands/snapshot_scenes.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "common/base/exit_codes.hpp"
#include "common/cli/output_files.hpp"
#include "common/dataset/series_member.hpp"
#include "common/image/srgb.hpp"
#include "common/wire/scene_file.hpp"

namespace multitetra {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Fetches a surface.
TakenSurface taken_surface(const SurfaceOrder& order, Client& client, DatasetRequest& dataset,
                           const IsosurfaceRequest& request) {
  const auto fetched = client.fetch(dataset.info,
                                    {.dataset = dataset.info.name,
                                     .request = request,
                                     .steps = StepPolicy::kFinalOnly,
                                     .cached_tile_digests = {},
                                     .scalars = dataset.scalars},
                                    [](const FetchedStep&) {});
  if (!fetched) exit_with(fetched.error());
  const CommittedStep& step = *fetched->step;
  TakenSurface taken{.part = {.info = &dataset.info,
                              .notices = &dataset.notices,
                              .name = surface_name(dataset.info),
                              .product = "picture"},
                     .bytes = step.end.payload_bytes};
  finish(taken.part, step, dataset.scalars, order.surface, {.quiet = order.quiet});
  if (const auto& scalars = step.begin.scalars) {
    taken.colors = order.surface.query.colors;
    taken.colors->low = scalars->low;
    taken.colors->high = scalars->high;
  }
  return taken;
}

// Returns the samples of the scene's first dataset that is not a label.
FetchedVolume taken_volume(const SurfaceOrder& order, const VolumeArguments& arguments,
                           Client& client, const Scene& scene) {
  const auto one = std::find_if(scene.datasets.begin(), scene.datasets.end(), [](const auto& each) {
    return !each.info.member || !each.info.member->label;
  });
  if (one == scene.datasets.end()) {
    throw ExitError(
        kUsage, "--volume shows samples, and labels have none; choose the dataset of their image.");
  }
  auto volume =
      fetched_volume(arguments, client, one->info, index_to_output(order.surface, one->info));
  if (!volume) exit_with(volume.error());
  return *std::move(volume);
}

}  // namespace

std::vector<Scene> scenes_of(const std::filesystem::path& picture, ConnectedRequests& connected) {
  std::vector<DatasetRequest>& all = connected.datasets;
  const auto time = [&](const DatasetRequest& one) {
    return connected.is_series ? one.info.member->time : std::nullopt;
  };
  std::stable_sort(all.begin(), all.end(),
                   [&](const auto& a, const auto& b) { return time(a) < time(b); });
  std::vector<Scene> scenes;
  for (auto from = all.begin(); from != all.end();) {
    const auto to =
        std::find_if(from, all.end(), [&](const auto& one) { return time(one) != time(*from); });
    const std::string& name = from->info.name;
    scenes.push_back(
        {.datasets = {from, to},
         .picture_file = file_of_part(picture, name.substr(name.rfind('.') + 1)).string()});
    from = to;
  }
  if (scenes.size() == 1) scenes.front().picture_file = picture.string();
  return scenes;
}

Result<std::vector<DrawnSurface>> appearances_of(const std::vector<double>& opacities,
                                                 const std::vector<std::string>& surface_colors,
                                                 std::span<const DatasetRequest> datasets) {
  const auto wrong = [](const std::string& text) {
    return fail(ErrorCode::kInvalidArgument, text);
  };
  std::vector<std::optional<std::uint32_t>> own_colors;
  for (const DatasetRequest& dataset : datasets) {
    const auto& member = dataset.info.member;
    const bool has_own = member && dataset.requests.size() == 1;
    own_colors.insert(own_colors.end(), dataset.requests.size(),
                      has_own ? display_color(*member) : std::nullopt);
  }
  const std::size_t count = own_colors.size();
  const auto fits = [&](std::size_t named) { return named == 0 || named == 1 || named == count; };
  const std::string surfaces = std::to_string(count) + (count == 1 ? " surface" : " surfaces");
  if (!fits(opacities.size())) {
    return wrong("--opacity: give one value for all surfaces or one for each; there are " +
                 surfaces + ".");
  }
  if (!fits(surface_colors.size())) {
    return wrong("--surface-color: give one color for all surfaces or one for each; there are " +
                 surfaces + ".");
  }
  std::vector<DrawnSurface> appearances(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (!opacities.empty()) {
      appearances[i].opacity = opacities[i % opacities.size()];
      if (!(appearances[i].opacity > 0 && appearances[i].opacity <= 1)) {
        return wrong("--opacity must be more than 0 and at most 1.");
      }
    }
    if (!surface_colors.empty()) {
      const std::string& text = surface_colors[i % surface_colors.size()];
      const auto color = color_from(text);
      if (!color) {
        return wrong("--surface-color: \"" + text +
                     "\" is not a color; write for example #dd8265.");
      }
      appearances[i].color = linear_light(unpacked(*color));
    } else if (own_colors[i]) {
      appearances[i].color = linear_light(unpacked(*own_colors[i]));
    } else if (count > 1) {
      const auto color = part_color(i);
      appearances[i].color = Light{static_cast<float>(color[0]), static_cast<float>(color[1]),
                                   static_cast<float>(color[2])};
    }
  }
  return appearances;
}

Affine index_to_output(const SurfaceArguments& arguments, const DatasetInfo& info) {
  return composed(output_map(arguments, info), inverse(grid_to_index(info)));
}

Taken taken_from(const SurfaceOrder& order, const VolumeArguments& volume, Client& client,
                 const Scene& scene) {
  Taken taken;
  const auto requested = Clock::now();
  if (volume.is_shown()) taken.volume = taken_volume(order, volume, client, scene);
  for (DatasetRequest& dataset : scene.datasets) {
    for (const IsosurfaceRequest& request : dataset.requests) {
      taken.surfaces.push_back(taken_surface(order, client, dataset, request));
    }
  }
  taken.fetch_seconds = seconds_since(requested);
  return taken;
}

}  // namespace multitetra
