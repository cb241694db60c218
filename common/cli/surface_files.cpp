#include "common/cli/surface_files.hpp"

#include <map>
#include <vector>

#include "common/wire/scene_file.hpp"

namespace multitetra {

std::string file_bytes(const SurfaceFile& surface, MeshFormat format, MeshCodec codec) {
  const OutputSurface& output = *surface.surface;
  return mesh_file(output.mesh, format,
                   {.name = surface.name,
                    .lattice = output.lattice,
                    .min_component = output.min_component,
                    .world = output.world,
                    .codec = codec});
}

void write_surfaces(std::span<const SurfaceFile> surfaces, MeshFormat format, MeshCodec codec) {
  if (format != MeshFormat::kGlb) {
    for (const SurfaceFile& one : surfaces) write_file(one.file, file_bytes(one, format, codec));
    return;
  }
  std::map<std::string, std::vector<const SurfaceFile*>> files;
  for (const SurfaceFile& one : surfaces) files[one.file].push_back(&one);
  for (const auto& [file, of_file] : files) {
    std::vector<ScenePart> parts;
    for (const SurfaceFile* const one : of_file) {
      parts.push_back({.name = one->name, .mesh = &one->surface->mesh, .color = one->color});
    }
    write_file(file, scene_glb(parts, of_file.front()->surface->world, codec));
  }
}

}  // namespace multitetra
