#include "client/commands/surface_appearances.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "common/dataset/series_member.hpp"
#include "common/image/srgb.hpp"
#include "common/wire/scene_file.hpp"

namespace multitetra {

Result<std::vector<DrawnSurface>> appearances_of(const SnapshotArguments& arguments,
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
  if (!fits(arguments.opacities.size())) {
    return wrong("--opacity: give one value for all surfaces or one for each; there are " +
                 surfaces + ".");
  }
  if (!fits(arguments.surface_colors.size())) {
    return wrong("--surface-color: give one color for all surfaces or one for each; there are " +
                 surfaces + ".");
  }
  std::vector<DrawnSurface> appearances(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (!arguments.opacities.empty()) {
      appearances[i].opacity = arguments.opacities[i % arguments.opacities.size()];
      if (!(appearances[i].opacity > 0 && appearances[i].opacity <= 1)) {
        return wrong("--opacity must be more than 0 and at most 1.");
      }
    }
    if (!arguments.surface_colors.empty()) {
      const std::string& text = arguments.surface_colors[i % arguments.surface_colors.size()];
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

}  // namespace multitetra
