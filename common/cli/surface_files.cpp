#include "common/cli/surface_files.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "common/cli/output_files.hpp"
#include "common/request/request_notices.hpp"
#include "common/wire/scene_file.hpp"

namespace multitetra {

std::vector<std::string> files_of(const std::string& output, MeshFormat format,
                                  std::span<const DatasetInfo* const> datasets) {
  const auto series = [](const DatasetInfo* one) {
    return one->member ? one->member->series : std::string();
  };
  const auto time = [](const DatasetInfo* one) {
    return one->member ? one->member->time : std::nullopt;
  };
  const auto have_same = [&](const auto& property) {
    return std::all_of(datasets.begin(), datasets.end(), [&](const DatasetInfo* one) {
      return property(one) == property(datasets.front());
    });
  };
  const bool is_one_scene = format == MeshFormat::kGlb && have_same(time);
  const bool is_one_series = have_same(series);
  std::vector<std::string> files;
  for (const DatasetInfo* const one : datasets) {
    const std::string prefix = series(one) + ".";
    const bool has_prefix = is_one_series && one->name.starts_with(prefix);
    const std::string name = has_prefix ? one->name.substr(prefix.size()) : one->name;
    files.push_back(is_one_scene ? output : file_of_part(output, name).string());
  }
  return files;
}

std::vector<std::string> leave_out_empty_files(std::span<NamedMesh> surfaces) {
  std::set<std::string> with_triangles;
  for (const NamedMesh& one : surfaces) {
    if (one.surface->components > 0) with_triangles.insert(one.file);
  }
  std::vector<std::string> names;
  for (NamedMesh& one : surfaces) {
    if (with_triangles.contains(one.file)) continue;
    one.file.clear();
    names.push_back(one.name.text);
  }
  if (names.empty()) return {};
  return {not_written_text(names)};
}

std::string file_bytes(const NamedMesh& surface, MeshFormat format, MeshCodec codec) {
  const OutputSurface& output = *surface.surface;
  return mesh_file(output.mesh, format,
                   {.name = surface.name,
                    .lattice = output.lattice,
                    .min_component = output.min_component,
                    .world = output.world,
                    .codec = codec});
}

void write_surfaces(std::span<const NamedMesh> surfaces, MeshFormat format, MeshCodec codec) {
  if (format != MeshFormat::kGlb) {
    for (const NamedMesh& one : surfaces) {
      if (!one.file.empty()) write_file(one.file, file_bytes(one, format, codec));
    }
    return;
  }
  std::map<std::string, std::vector<const NamedMesh*>> files;
  for (const NamedMesh& one : surfaces) {
    if (!one.file.empty()) files[one.file].push_back(&one);
  }
  for (const auto& [file, of_file] : files) {
    std::vector<ScenePart> parts;
    for (const NamedMesh* const one : of_file) {
      parts.push_back({.name = one->name, .mesh = &one->surface->mesh});
    }
    write_file(file, scene_glb(parts, of_file.front()->surface->world, codec));
  }
}

}  // namespace multitetra
