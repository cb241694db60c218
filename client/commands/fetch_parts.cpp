#include "client/commands/fetch_parts.hpp"

#include <algorithm>

#include "common/base/number_text.hpp"
#include "common/cli/output_files.hpp"
#include "common/cli/surface_output.hpp"

namespace multitetra {

std::vector<FetchPart> parts_of(const FetchArguments& arguments, MeshFormat format,
                                std::span<const DatasetRequest> series) {
  std::vector<const DatasetInfo*> infos;
  for (const DatasetRequest& one : series) infos.push_back(&one.info);
  std::vector<std::string> files = files_of(arguments.output.file, format, infos);
  if (series.empty()) files.push_back(arguments.output.file);
  const std::vector<double>& isovalues = arguments.order.surface.query.isovalues;
  std::vector<FetchPart> parts;
  for (std::size_t dataset = 0; dataset < files.size(); ++dataset) {
    for (std::size_t i = 0; i < std::max<std::size_t>(1, isovalues.size()); ++i) {
      FetchPart part{.dataset = dataset,
                     .request = i,
                     .isovalue = {},
                     .mesh_file = files[dataset],
                     .steps_directory = arguments.steps_directory};
      const auto add_folder = [&](const std::string& name) {
        if (!part.steps_directory.empty()) part.steps_directory /= name;
      };
      if (!series.empty()) add_folder(infos[dataset]->name);
      if (isovalues.size() > 1) {
        const std::string number = shortest_text(isovalues[i]);
        part.isovalue = "isovalue " + number;
        if (!holds_several(format)) part.mesh_file = file_of_part(part.mesh_file, number);
        add_folder("isovalue_" + number);
      }
      parts.push_back(std::move(part));
    }
  }
  return parts;
}

SurfaceName name_of(const FetchPart& part, const DatasetInfo& info, bool is_series) {
  SurfaceName name = surface_name(info);
  if (part.isovalue.empty()) return name;
  name.color.reset();  // Isovalues have different ones.
  name.text = is_series ? name.text + ", " + part.isovalue : part.isovalue;
  return name;
}

}  // namespace multitetra
