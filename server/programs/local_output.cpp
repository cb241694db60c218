#include "server/programs/local_output.hpp"

#include <algorithm>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "common/base/exit_codes.hpp"
#include "common/base/json.hpp"
#include "common/base/number_text.hpp"
#include "common/base/vec3.hpp"
#include "common/cli/human_units.hpp"
#include "common/dataset/length_units.hpp"
#include "common/json/json_report.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "common/request/lattice_limit.hpp"
#include "common/request/request_notices.hpp"
#include "common/request/threshold_shrinking.hpp"
#include "common/wire/scalar_codes.hpp"
#include "server/core/sampling/vertex_scalars.hpp"
#include "server/core/thresholds/threshold_map.hpp"
#include "server/programs/thread_options.hpp"
#include "server/volume/volume_files.hpp"

namespace multitetra {
namespace {

// Reads thresholds from a volume of any format.
Result<ThresholdGrid> read_volume_of_thresholds(const std::filesystem::path& file, double elsewhere,
                                                const std::string& length_unit) {
  try {
    bool has_infinite = false;
    Volume volume = read_volume(file, {.notice = [&](const std::string& sentence) {
                                  has_infinite |= sentence.find(kInfiniteNotice) != sentence.npos;
                                }});
    if (has_infinite) {
      return fail(ErrorCode::kInvalidArgument,
                  "Cannot use the threshold grid \"" + file.string() +
                      "\": it has infinite thresholds; give finite ones, or NaN for none.");
    }
    const double factor = length_factor(volume.meaning.length_unit, length_unit).value_or(1);
    if (factor != 1) {
      for (Vec3& column : volume.index_to_world.columns) column = scaled(column, factor);
      volume.index_to_world.translation = scaled(volume.index_to_world.translation, factor);
    }
    std::vector<float> thresholds(volume.size());
    std::visit(
        [&](const auto& samples) { std::copy(samples.begin(), samples.end(), thresholds.begin()); },
        volume.samples);
    return shrunk(
        {.dims = volume.dims, .index_to_world = volume.index_to_world, .thresholds = thresholds},
        elsewhere);
  } catch (const VolumeFileError& error) {
    return fail(ErrorCode::kInvalidArgument, error.what());
  }
}

// Returns the distance that the request's error bounds, if it is one.
std::optional<double> error_bound(const LocalSurface& surface, const DatasetInfo& info) {
  const bool is_bounded = surface.is_error_bounded && surface.request.topology_tolerance == 0 &&
                          surface.request.error_measure == ErrorMeasure::kCertified;
  if (!is_bounded) return std::nullopt;
  return largest_threshold(surface.request, info);
}

std::uint64_t unsigned_of(std::int64_t count) { return static_cast<std::uint64_t>(count); }

// Prints the result for people.
void print(const OutputPart& part) {
  const SurfaceReport& report = part.report;
  const MeshTopology& topology = report.surface->topology;
  std::cout << (part.file.empty() ? "not written" : part.file) << ": \"" << part.name.text
            << "\", isovalue " << shortest_text(report.request.isovalue) << ", "
            << human_count_of(part.surface.mesh.triangles.size(), "triangle") << ", "
            << human_count(part.surface.mesh.positions.size()) << " vertices";
  if (report.surface->tetrahedra > 0) {
    std::cout << ", from " << human_count(report.surface->tetrahedra) << " tetrahedra";
  }
  std::cout << "\n  ";
  if (part.surface.components != part.surface.total_components) {
    std::cout << "whole surface: " << human_count_of(unsigned_of(topology.triangles), "triangle")
              << ", ";
  }
  std::cout << "Euler characteristic " << topology.euler_characteristic << ", "
            << human_count_of(unsigned_of(topology.components), "component") << ", "
            << topology.border_edges << " edges on the border, " << topology.open_edges << " open, "
            << topology.nonmanifold_edges << " non-manifold";
  if (const auto common = report.more.find("common_triangles"); common != report.more.end()) {
    std::cout << ", " << human_count(common->get<std::uint64_t>())
              << " triangles shared with neighbors";
  }
  std::cout << "\n";
  if (topology.border_edges > 0) {
    std::cout << "  open " << open_reason(*part.info) << "\n";
  }
  if (report.written && report.written->self_intersections) {
    std::cout << "  " << human_count_of(report.written->self_intersections->triangles, "triangle")
              << " that intersect others\n";
  }
}

}  // namespace

void add_local_options(Command& command, LocalArguments& a, const std::string& dataset) {
  a.surface.threshold_files = {.formats = "Any format that `prepare` reads (`formats` lists them)",
                               .read = read_volume_of_thresholds};
  command.add_option("file", a.dataset, dataset)->required()->type_name("DATASET");
  add_output_options(command, a.surface, a.output);
  add_request_options(
      command, a.surface,
      {FieldGroup::kSurface, FieldGroup::kThresholds, FieldGroup::kSize, FieldGroup::kColors});
  add_threads_option(command, a.threads);
}

std::vector<std::string> files_of_isovalues(const LocalArguments& arguments) {
  const std::string& output = arguments.output.file;
  const MeshFormat format = mesh_format_of(output, arguments.surface);
  const std::vector<double>& isovalues = arguments.surface.query.isovalues;
  if (isovalues.size() <= 1) return {output};
  if (holds_several(format)) return std::vector<std::string>(isovalues.size(), output);
  std::vector<std::string> files;
  for (const double isovalue : isovalues) {
    files.push_back(file_of_part(output, shortest_text(isovalue)).string());
  }
  return files;
}

LocalOutput::LocalOutput(const LocalArguments& arguments, Progress& progress)
    : arguments_(arguments), progress_(progress), notices_(arguments.output.quiet) {
  auto scalars = scalars_for(arguments.surface.query);
  if (!scalars) throw std::invalid_argument(scalars.error().text);
  scalars_ = *std::move(scalars);
  if (scalars_) field_ = open_dataset(scalars_->dataset);
}

std::vector<IsosurfaceRequest> LocalOutput::requests(const DatasetInfo& info) {
  auto requests = requests_from(arguments_.surface, info);
  if (!requests) throw ExitError(kUsage, requests.error().text);
  for (const IsosurfaceRequest& request : *requests) {
    if (const auto fits = check_lattice(request, info); !fits) {
      throw ExitError(kUsage, "--lattice: " + fits.error().text);
    }
    notices_.add(request_notices(request, info));
  }
  return *std::move(requests);
}

void LocalOutput::add(LocalSurface surface, const DatasetInfo& info, const std::string& file) {
  SurfaceName name = surface_name(info);
  if (arguments_.surface.query.isovalues.size() > 1) {
    name.text = "isovalue " + shortest_text(surface.request.isovalue);
    name.color.reset();
  }
  add(std::move(surface), info, file, std::move(name), /*names_itself=*/false);
}

void LocalOutput::add(LocalSurface surface, const DatasetInfo& info, const std::string& file,
                      SurfaceName name, bool names_itself) {
  const IsosurfaceRequest& request = surface.request;
  surface.whole.topology =
      surface.topology
          ? *surface.topology
          : topology(surface.mesh, data_border(info, request.lattice_resolution,
                                               request.topology_tolerance, surface.finest_spacing));
  surface.whole.error_bound = error_bound(surface, info);
  OutputPart part{.info = &info,
                  .notices = &notices_,
                  .name = std::move(name),
                  .file = file,
                  .max_bytes = arguments_.surface.query.request.max_bytes,
                  .names_itself = names_itself};
  if (scalars_) {
    part.report.colors = add_scalars(surface.mesh, info);
    part.report.color_by = field_->info.name;
  }
  part.report.request = request;
  part.report.surface = surface.whole;
  if (surface.common_triangles) part.report.more["common_triangles"] = *surface.common_triangles;
  finish(part, surface.mesh, arguments_.surface, arguments_.output);
  parts_.push_back(std::move(part));
}

ScalarRange LocalOutput::add_scalars(LatticeMesh& mesh, const DatasetInfo& surface) const {
  if (const auto fits = check_same_world(*scalars_, surface, field_->info); !fits) {
    throw ExitError(kUsage, fits.error().text);
  }
  const ScalarRange range = range_for(*scalars_, field_->info);
  const VertexScalars found = vertex_scalars(*field_, mesh, grid_to_world(surface));
  if (field_->check) field_->check();
  const std::string codes = encode_scalars(mesh.vertices, found.values, range);
  mesh.scalars = decode_scalars(codes, mesh.vertices, range).value();
  if (!arguments_.output.quiet) {
    std::cerr << color_accuracy_text(range, found.largest_deviation) << std::endl;
  }
  return range;
}

void LocalOutput::write_reports() {
  const bool are_several = parts_.size() > 1 || is_folder_of_datasets(arguments_.dataset);
  std::vector<Json> reports;
  for (OutputPart& part : parts_) {
    part.report.notices = notices_.texts();
    part.report.more["seconds"] = progress_.seconds();
    reports.push_back(json_of(part.report));
  }
  write_report(std::move(reports), are_several, arguments_.output);
}

void LocalOutput::write(bool may_lack_some) {
  if (const OutputPart* empty = forbidden_empty(parts_, arguments_.surface, may_lack_some)) {
    progress_.finish();
    write_reports();
    throw ExitError(kEmptySurface, not_written_text(empty->file));
  }
  progress_.begin("files");
  write_files(parts_, arguments_.surface, arguments_.output,
              /*counts_self_intersections=*/!arguments_.output.quiet);
}

int LocalOutput::report() {
  progress_.finish();
  write_reports();
  for (const OutputPart& part : parts_) {
    if (!arguments_.output.json && !arguments_.output.quiet) print(part);
  }
  const bool is_sound = std::all_of(parts_.begin(), parts_.end(), [](const OutputPart& part) {
    return part.report.surface->topology.is_sound();
  });
  if (is_sound) return kOk;
  std::cerr << "multitetra-server: a mesh has open, non-manifold or degenerate parts; this is a "
               "bug, please report it.\n";
  return kFailed;
}

}  // namespace multitetra
