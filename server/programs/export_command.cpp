#include <cmath>
#include <filesystem>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "common/base/exit_codes.hpp"
#include "common/base/json.hpp"
#include "common/base/utf8.hpp"
#include "common/cli/human_units.hpp"
#include "common/json/json_report.hpp"
#include "common/request/surface_query.hpp"
#include "common/wire/mesh_files.hpp"
#include "server/core/spectrum/crossed_octants.hpp"
#include "server/dataset/dataset.hpp"
#include "server/extraction/normal_encoder.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/programs/commands.hpp"
#include "server/programs/page_export.hpp"
#include "server/programs/progress.hpp"
#include "server/programs/thread_options.hpp"
#include "server/tilesets/cell_glb.hpp"
#include "server/tilesets/neuroglancer.hpp"
#include "server/tilesets/tileset_json.hpp"
#include "server/tilesets/whole_levels.hpp"

namespace multitetra {
namespace {

struct ExportArguments {
  std::string file;
  std::string folder;
  std::string page;  // The folder of a page instead of a surface; else empty.
  std::string format = "3dtiles";
  std::vector<double> isovalues;
  double error = TilesetSettings{}.error;
  std::string quality;  // Empty: the error.
  std::string codec;    // Empty: the format's own.
  bool sharded = false;
  int threads = 0;
  bool json = false;
  bool quiet = false;
};

// Totals of the files written so far.
struct Exported {
  std::uint64_t files = 0;
  std::uint64_t bytes = 0;
  std::uint64_t triangles = 0;

  void add(const Exported& other) {
    files += other.files;
    bytes += other.bytes;
    triangles += other.triangles;
  }
};

void write_into(const std::filesystem::path& folder, const std::filesystem::path& name,
                const std::string& bytes, Exported& exported) {
  const std::filesystem::path path = folder / name;
  std::filesystem::create_directories(path.parent_path());
  write_file(path, bytes);
  ++exported.files;
  exported.bytes += bytes.size();
}

class Exporter {
 public:
  // `report` receives the percentage done.
  Exporter(const SurfaceExtractor& extractor, const Tileset& tileset, std::filesystem::path folder,
           std::function<void(double)> report)
      : extractor_(extractor),
        tree_(tileset),
        folder_(std::move(folder)),
        report_(std::move(report)) {}

  [[nodiscard]] const Exported& exported() const { return exported_; }

  // Writes files as served below /v1/3dtiles/NAME/iso/ISOVALUE.
  void write_tilesets() {
    const std::string id = tree_.id();
    for_cells([&](const OctreeCube& cell) {
      const LatticeMesh mesh = surface(tree_.request(cell));
      exported_.triangles += mesh.triangles.size();
      const CellFacts facts{.is_empty = mesh.triangles.empty(), .crossed_octants = crossed(cell)};
      if (cell == tree_.root()) write("tileset.json", tileset_json(tree_, cell, facts, id + "/"));
      write(id + "/" + cell_name(cell) + ".json", tileset_json(tree_, cell, facts, ""));
      if (!facts.is_empty)
        write(id + "/" + cell_name(cell) + ".glb",
              cell_glb(mesh, tree_.info(), cell, tree_.settings().codec));
    });
  }

  // Returns the mesh files of one isovalue without writing them.
  MeshFiles segment() {
    MeshFragments fragments;
    for_cells([&](const OctreeCube& cell) {
      fragments[cell] = std::make_shared<const std::string>(fragment(cell));
    });
    return mesh_files_of(tree_, fragments);
  }

  // Writes one file. Skips levels with nearly as many triangles as the previous one.
  void write_levels(MeshCodec codec) {
    constexpr double kFewer = 0.75;
    const std::vector<WholeLevel> planned = whole_levels(tree_.info(), tree_.settings());
    std::vector<LevelMesh> levels;
    for (std::size_t i = 0; i < planned.size(); ++i) {
      LatticeMesh mesh = surface(planned[i].request);
      report_(100.0 * static_cast<double>(i + 1) / static_cast<double>(planned.size()));
      if (mesh.triangles.empty()) break;
      const auto triangles = static_cast<double>(mesh.triangles.size());
      if (levels.empty() ||
          triangles <= kFewer * static_cast<double>(levels.back().mesh.triangles.size())) {
        exported_.triangles += mesh.triangles.size();
        levels.push_back({.mesh = std::move(mesh), .error_bound = planned[i].error_bound});
      }
    }
    write("surface.glb", whole_levels_glb(levels, tree_.info(), codec));
  }

 private:
  [[nodiscard]] std::uint32_t crossed(const OctreeCube& cell) const {
    return crossed_octants(extractor_.dataset(), cell, tree_.settings().isovalue);
  }

  // Visits the cells that the surface may cross, and reports the progress.
  template <typename Visit>
  void for_cells(const Visit& visit) {
    std::vector<OctreeCube> left = {tree_.root()};
    double percent = 0;
    while (!left.empty()) {
      const OctreeCube cell = left.back();
      left.pop_back();
      visit(cell);
      const std::uint32_t octants = tree_.is_leaf(cell) ? 0 : crossed(cell);
      const double octant = std::ldexp(12.5, -3 * (tree_.root().exponent - cell.exponent));
      for (int i = 0; i < 8; ++i) {
        if ((octants >> i & 1U) != 0) {
          left.push_back(cell.child(i));
        } else {
          percent += octant;
        }
      }
      report_(percent);
    }
  }

  LatticeMesh surface(const IsosurfaceRequest& request) {
    const StepRequest step = final_step(request);
    LatticeMesh mesh = weld(extractor_.extract(step).tiles, request.lattice_resolution);
    const bool is_coarse = step.finest_spacing >= kSpectrumSpacing;
    mesh.normals =
        rounded_normals(extractor_.dataset(), mesh, request.normal_bits,
                        is_coarse ? NormalSource::kCoarseSamples : NormalSource::kSamples);
    return mesh;
  }

  std::string fragment(const OctreeCube& cell) {
    std::vector<LatticeMesh> pieces;
    for (const IsosurfaceRequest& request : tree_.fragment_requests(cell)) {
      pieces.push_back(surface(request));
      exported_.triangles += pieces.back().triangles.size();
    }
    return mesh_fragment(weld(pieces, pieces.front().resolution), cell);
  }

  void write(const std::filesystem::path& name, const std::string& bytes) {
    write_into(folder_, name, bytes, exported_);
  }

  const SurfaceExtractor& extractor_;
  const Tileset& tree_;
  std::filesystem::path folder_;
  std::function<void(double)> report_;
  Exported exported_;
};

// Writes the given segments as served below /v1/neuroglancer/NAME/surfaces.
void write_segments(const ExportArguments& arguments, DatasetInfo info,
                    const std::map<std::uint64_t, MeshFiles>& segments, Exported& exported) {
  const auto write = [&](const std::string& name, const std::string& bytes) {
    write_into(arguments.folder, name, bytes, exported);
  };
  info.suggested_isovalues = arguments.isovalues;
  write("info", mesh_info_json(info, arguments.sharded ? MeshLayout::kShards : MeshLayout::kFiles));
  write("segment_properties/info", segment_properties_json(info));
  if (arguments.sharded) {
    write("0.shard", mesh_shard(segments));
    return;
  }
  for (const auto& [segment, files] : segments) {
    write(std::to_string(segment), files.data);
    write(std::to_string(segment) + ".index", files.manifest);
  }
}

int export_as_page(const ExportArguments& arguments) {
  const ExportedPage page = export_page(arguments.file, arguments.page);
  if (arguments.json) {
    std::cout << text_of(Json{{"folder", arguments.page},
                              {"datasets", page.datasets},
                              {"files", page.files},
                              {"bytes", page.bytes}});
  } else if (!arguments.quiet) {
    std::cout << printable(arguments.page, /*keeps_lines=*/false) << ": " << page.files
              << " files, " << human_bytes(page.bytes)
              << "; upload them to any web space that answers requests for ranges\n";
  }
  return kOk;
}

// Checks settings like those in a server's path.
TilesetSettings settings_of(double isovalue, double error, CellCodec codec) {
  const auto settings = tileset_settings_from(
      text_of(TilesetSettings{.isovalue = isovalue, .error = error, .codec = codec}));
  if (!settings) throw std::invalid_argument(settings.error().text);
  return *settings;
}

int export_tilesets(ExportArguments arguments) {
  if (arguments.folder.empty()) throw UsageError("--output", "is required, or --page.");
  if (arguments.sharded && arguments.format != "neuroglancer") {
    throw UsageError("--sharded", "only --format neuroglancer supports shards.");
  }
  const bool is_meshopt = arguments.codec == kMeshCodecs.of(MeshCodec::kMeshopt);
  if (is_meshopt && arguments.format == "neuroglancer") {
    throw UsageError("--codec", "meshes of --format neuroglancer have Draco alone.");
  }
  const ThreadLimit limit(arguments.threads);
  Progress progress("export", 1, arguments.quiet || arguments.json);
  const DatasetPtr dataset = open_dataset(arguments.file);
  const std::vector<double>& suggested = dataset->info.suggested_isovalues;
  if (arguments.isovalues.empty() && suggested.empty()) {
    throw UsageError("--isovalue", "the dataset has no suggested isovalue; give one.");
  }
  if (arguments.isovalues.empty()) arguments.isovalues = {suggested.front()};
  const SurfaceExtractor extractor(dataset);
  progress.begin("cells");
  Exported exported;
  std::map<std::uint64_t, MeshFiles> segments;
  const double count = static_cast<double>(arguments.isovalues.size());
  for (std::size_t i = 0; i < arguments.isovalues.size(); ++i) {
    const TilesetSettings settings =
        settings_of(arguments.isovalues[i], arguments.error,
                    is_meshopt ? CellCodec::kMeshopt : CellCodec::kDraco);
    const Tileset tileset(dataset->info, settings);
    std::filesystem::path folder = arguments.folder;
    if (arguments.isovalues.size() > 1) {
      folder = folder / "iso" / text_of(TilesetSettings{.isovalue = settings.isovalue});
    }
    Exporter exporter(extractor, tileset, std::move(folder), [&](double percent) {
      progress.update((100 * static_cast<double>(i) + percent) / count, 100, "%");
    });
    if (arguments.format == "3dtiles") {
      exporter.write_tilesets();
    } else if (arguments.format == "glb-lods") {
      exporter.write_levels(is_meshopt ? MeshCodec::kMeshopt : MeshCodec::kNone);
    } else {
      segments[segment_of(settings.isovalue)] = exporter.segment();
    }
    exported.add(exporter.exported());
  }
  if (!segments.empty()) write_segments(arguments, dataset->info, segments, exported);
  progress.finish();
  if (arguments.json) {
    std::cout << text_of(Json{{"folder", arguments.folder},
                              {"format", arguments.format},
                              {"isovalues", arguments.isovalues},
                              {"error", arguments.error},
                              {"files", exported.files},
                              {"bytes", exported.bytes},
                              {"triangles", exported.triangles},
                              {"seconds", progress.seconds()}});
  } else if (!arguments.quiet) {
    std::cout << printable(arguments.folder, /*keeps_lines=*/false) << ": " << exported.files
              << " files, " << exported.triangles << " triangles on all levels\n";
  }
  if (exported.triangles == 0) {
    throw ExitError(kEmptySurface, "The surface is empty: the files have no triangles.");
  }
  return kOk;
}

}  // namespace

void add_export_command(Command& program, Run& run) {
  const auto arguments = std::make_shared<ExportArguments>();
  Command* command = program.add_subcommand(
      "export", "Write a surface with its levels of detail as files for a web server");
  command
      ->add_option("file", arguments->file,
                   "Dataset: a file (.mtd) or the address of a dataset (https://, s3://bucket/key)")
      ->required()
      ->type_name("DATASET");
  command->add_option("-o,--output", arguments->folder, "Folder to write to; created if missing")
      ->type_name("FOLDER");
  command
      ->add_option("--page", arguments->page,
                   "Folder for a page instead of a surface; the viewer and the dataset, or all "
                   "datasets of a folder, for a web space without a server")
      ->type_name("FOLDER")
      ->excludes("--output");
  command
      ->add_option(
          "--format", arguments->format,
          "Format; 3dtiles: tileset.json, for CesiumJS and others, neuroglancer: a precomputed "
          "multi-resolution mesh with a segment for each isovalue, glb-lods: surface.glb, whole "
          "surfaces as levels of MSFT_lod")
      ->one_of({"3dtiles", "neuroglancer", "glb-lods"})
      ->capture_default_str();
  command
      ->add_option("--isovalue", arguments->isovalues,
                   "Isovalue, or several with commas; default: the dataset's suggestion. Several "
                   "become tilesets in FOLDER/iso/VALUE, or segments of one mesh")
      ->delimiter(',')
      ->type_name("NUMBER,...");
  command->add_option("--error", arguments->error, "Largest error of the finest level, in voxels")
      ->within(0.0, 1e9)
      ->capture_default_str();
  command
      ->add_option("--quality", arguments->quality, "Instead of an error: 2, 0.5, 0.25 or 0 voxels")
      ->one_of({"draft", "normal", "fine", "exact"})
      ->excludes("--error");
  command
      ->add_option(
          "--codec", arguments->codec,
          "Compression of GLB files by EXT_meshopt_compression; default: Draco in 3dtiles, "
          "none in glb-lods")
      ->one_of({"meshopt"});
  command->add_flag("--sharded", arguments->sharded,
                    "For neuroglancer: manifests and fragments in one shard");
  add_threads_option(*command, arguments->threads);
  command->add_flag("--json", arguments->json, "Print a JSON report");
  command->add_flag("--quiet", arguments->quiet, "Print errors only");
  command->footer(
      "Examples:\n"
      "  multitetra-server export head.mtd --isovalue 500.5 -o site/head\n"
      "  multitetra-server export head.mtd --isovalue 500.5,900.5 --format neuroglancer -o "
      "site/head_mesh\n"
      "  multitetra-server export head.mtd --format glb-lods -o site/head\n"
      "  multitetra-server export head.mtd --page site");
  command->callback([arguments, &run] {
    if (!arguments->quality.empty()) {
      arguments->error = quality_error_from(arguments->quality).value();
    }
    run = [arguments] {
      return arguments->page.empty() ? export_tilesets(*arguments) : export_as_page(*arguments);
    };
  });
}

}  // namespace multitetra
