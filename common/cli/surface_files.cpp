#include "common/cli/surface_files.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "common/base/exit_codes.hpp"
#include "common/base/json.hpp"
#include "common/cli/human_units.hpp"
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

namespace {

std::string file_bytes(std::span<const NamedMesh* const> surfaces, MeshFormat format,
                       MeshCodec codec) {
  const OutputSurface& first = *surfaces.front()->surface;
  if (surfaces.size() == 1) {
    return mesh_file(first.mesh, format,
                     {.name = surfaces.front()->name,
                      .lattice = first.lattice,
                      .min_component = first.min_component,
                      .world = first.world,
                      .codec = codec});
  }
  std::vector<ScenePart> parts;
  for (const NamedMesh* const one : surfaces) {
    parts.push_back({.name = one->name, .mesh = &one->surface->mesh});
  }
  return scene_glb(parts, first.world, codec);
}

// Writes one file, and sets what it holds of each surface.
void write_surfaces(std::span<const NamedMesh* const> surfaces, MeshFormat format, MeshCodec codec,
                    bool counts_self_intersections, std::span<WrittenMesh* const> written) {
  const std::string& file = surfaces.front()->file;
  std::string bytes;
  try {
    bytes = file_bytes(surfaces, format, codec);
  } catch (const MeshCoordinatesError& error) {
    throw ExitError(kUsage, file + ": " + error.what() + " Here: --coordinates index, or --shift " +
                                error.shift + ", which moves the surface and is in the report.");
  }
  const auto is_empty = [](const NamedMesh* one) { return one->surface->mesh.triangles.empty(); };
  if (!std::all_of(surfaces.begin(), surfaces.end(), is_empty)) {
    std::vector<WrittenMesh> found = read_back(bytes, format, counts_self_intersections);
    auto next = found.begin();
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
      if (is_empty(surfaces[i])) continue;
      require_same(*next, surfaces[i]->surface->mesh);
      *written[i] = *next++;
    }
  }
  write_file(file, bytes);
}

}  // namespace

std::vector<WrittenMesh> write_surfaces(std::span<const NamedMesh> surfaces, MeshFormat format,
                                        MeshCodec codec, bool counts_self_intersections) {
  std::vector<WrittenMesh> written(surfaces.size());
  std::map<std::string, std::vector<std::size_t>> files;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    if (!surfaces[i].file.empty()) files[surfaces[i].file].push_back(i);
  }
  for (const auto& [file, members] : files) {
    std::vector<const NamedMesh*> of_file;
    std::vector<WrittenMesh*> found;
    for (const std::size_t i : members) {
      of_file.push_back(&surfaces[i]);
      found.push_back(&written[i]);
    }
    write_surfaces(of_file, format, codec, counts_self_intersections, found);
  }
  return written;
}

std::vector<std::string> printing_notices(const std::string& file, const WrittenMesh& written,
                                          const DatasetInfo& info) {
  std::vector<std::string> notices;
  const std::int64_t open = written.topology.border_edges;
  if (open > 0) {
    notices.push_back(file + " is open at " +
                      human_count_of(static_cast<std::uint64_t>(open), "edge") +
                      " and cannot be printed: it ends " + open_reason(info) +
                      ", or --min-component removes small open components.");
  }
  if (written.self_intersections && written.self_intersections->triangles > 0) {
    notices.push_back(file + " has " +
                      human_count_of(written.self_intersections->triangles, "triangle") +
                      " that intersect others; --intersection-free avoids them.");
  }
  return notices;
}

void add_file(Json& report, const std::string& file, const OutputSurface& output,
              const WrittenMesh& written) {
  report["mesh_file"] = file;
  report["components_written"] = output.components;
  report["triangles_written"] = output.mesh.triangles.size();
  report["written"] = json_of(written);
}

}  // namespace multitetra
