#include "client/commands/snapshot_scenes.hpp"

#include <algorithm>
#include <optional>

#include "common/cli/output_files.hpp"

namespace multitetra {

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

}  // namespace multitetra
