#include "common/cli/surface_options.hpp"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "common/base/exit_codes.hpp"
#include "common/cli/human_units.hpp"
#include "common/request/request_notices.hpp"

namespace multitetra {
namespace {

std::string option_name(std::string_view field) {
  std::string name = "--" + std::string(field);
  std::replace(name.begin(), name.end(), '_', '-');
  return name;
}

// Checks that the mesh can be written in the requested space.
Result<void> check_space(const SurfaceArguments& arguments, const DatasetInfo& info) {
  if (!arguments.shift.empty() && arguments.query.coordinates != CoordinateSystem::kWorld) {
    return fail(ErrorCode::kInvalidArgument,
                "--shift applies to world coordinates only, not to --coordinates index.");
  }
  if (arguments.space == "native") return {};
  if (arguments.query.coordinates != CoordinateSystem::kWorld) {
    return fail(ErrorCode::kInvalidArgument,
                "--space applies to world coordinates only, not to --coordinates index.");
  }
  if (info.meaning.space != WorldSpace::kUnnamed) return {};
  return fail(
      ErrorCode::kInvalidArgument,
      "--space: the file of \"" + info.name +
          "\" does not define the directions of the world axes in a patient; use --space native.");
}

}  // namespace

void add_request_option(Command& command, const RequestField& field, Command::Parse parse) {
  const std::string name = option_name(field.name), help(field.help);
  Option* const option = field.value_syntax.empty()
                             ? command.add_switch(name, std::move(parse), help)
                             : command.add_parsed(name, std::move(parse), help)
                                   ->type_name(std::string(field.value_syntax))
                                   ->default_text(std::string(field.default_text));
  if (field.is_repeatable) option->repeatable();
  if (!field.is_everyday) option->group(std::string(title(field.group)));
}

void add_request_options(Command& command, SurfaceArguments& a,
                         std::initializer_list<FieldGroup> groups) {
  for (const RequestField& field : request_fields()) {
    const bool is_wanted = std::find(groups.begin(), groups.end(), field.group) != groups.end();
    if (!is_wanted) continue;
    add_request_option(command, field, [&a, &field](const std::string& text) {
      return field.set(field, text, a.query);
    });
  }
  if (std::find(groups.begin(), groups.end(), FieldGroup::kThresholds) == groups.end()) return;
  command
      .add_option("--threshold-grid", a.threshold_grid,
                  "Image whose voxels are the allowed errors; NaN: no error is given. " +
                      a.threshold_files.formats)
      ->type_name("FILE")
      ->group(std::string(title(FieldGroup::kThresholds)));
}

void add_output_options(Command& command, SurfaceArguments& a) {
  add_request_options(command, a, {FieldGroup::kFile});
  const std::string group(title(FieldGroup::kFile));
  command
      .add_option("--space", a.space,
                  "Axes of the mesh's world coordinates: native: those of the dataset, lps: to the "
                  "patient's left, back and head, ras: to the right, front and head")
      ->one_of({"native", "lps", "ras"})
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--shift", a.shift,
                  "Add this to world coordinates, as to have them near the origin: STL and Draco "
                  "files have 32-bit coordinates and are refused where these are too coarse")
      ->delimiter(',')
      ->expected(3)
      ->type_name("X,Y,Z")
      ->group(group);
  command
      .add_flag("--allow-empty", a.allow_empty,
                "Also write empty surfaces; without this option they are an error with exit code 6")
      ->group(group);
}

Result<std::vector<IsosurfaceRequest>> requests_from(const SurfaceArguments& arguments,
                                                     const DatasetInfo& info) {
  if (const auto checked = check_space(arguments, info); !checked) {
    return tl::unexpected(checked.error());
  }
  if (arguments.threshold_grid.empty()) return requests_for(arguments.query, info);
  SurfaceQuery query = arguments.query;
  auto grid = arguments.threshold_files.read(arguments.threshold_grid, query.request.error,
                                             info.meaning.length_unit);
  if (!grid) return tl::unexpected(grid.error());
  query.request.thresholds.grid = std::make_shared<const ThresholdGrid>(*std::move(grid));
  return requests_for(query, info);
}

Result<IsosurfaceRequest> request_of(const SurfaceArguments& arguments, const DatasetInfo& info) {
  if (arguments.query.isovalues.size() > 1) {
    return fail(ErrorCode::kInvalidArgument, "--isovalue: this command accepts one isovalue.");
  }
  auto requests = requests_from(arguments, info);
  if (!requests) return tl::unexpected(requests.error());
  return requests->front();
}

namespace {

// Returns whether the output converts between LPS and RAS, which negates x and y.
bool flips_x_and_y(const SurfaceArguments& arguments, const DatasetInfo& info) {
  if (arguments.query.coordinates != CoordinateSystem::kWorld || arguments.space == "native")
    return false;
  return info.meaning.space != (arguments.space == "lps" ? WorldSpace::kLps : WorldSpace::kRas);
}

PhysicalMeaning world_of(const SurfaceArguments& arguments, const DatasetInfo& info) {
  if (arguments.query.coordinates != CoordinateSystem::kWorld) return {};
  PhysicalMeaning world = info.meaning;
  if (arguments.space == "lps") world.space = WorldSpace::kLps;
  if (arguments.space == "ras") world.space = WorldSpace::kRas;
  return world;
}

}  // namespace

Affine output_map(const SurfaceArguments& arguments, const DatasetInfo& info) {
  if (arguments.query.coordinates != CoordinateSystem::kWorld) return grid_to_index(info);
  Affine map = grid_to_world(info);
  for (std::size_t axis = 0; axis < 2 && flips_x_and_y(arguments, info); ++axis) {
    for (Vec3& column : map.columns) column[axis] = -column[axis];
    map.translation[axis] = -map.translation[axis];
  }
  for (std::size_t axis = 0; axis < arguments.shift.size(); ++axis) {
    map.translation[axis] += arguments.shift[axis];
  }
  return map;
}

OutputSurface output_surface(const LatticeMesh& surface, const SurfaceArguments& arguments,
                             const DatasetInfo& info) {
  return output_surface(surface, arguments.query.min_component,
                        {.map = output_map(arguments, info), .world = world_of(arguments, info)},
                        info);
}

std::string removed_text(const OutputSurface& surface) {
  if (surface.components == surface.total_components) return {};
  return human_count(surface.components) + " of " + human_count(surface.total_components) +
         " components, those with a diagonal of " + human_number(surface.min_component) +
         " samples or more" +
         (surface.filled.count == 0 ? std::string() : "; " + filled_text(surface.filled));
}

std::string color_accuracy_text(const ScalarRange& range, double largest_deviation) {
  return "Colors between vertices may be off by up to " + human_number(largest_deviation) +
         ", those of vertices by " + human_number(0.5 * range.step()) + ".";
}

void require_codec(const SurfaceArguments& arguments, bool is_glb) {
  if (const auto fits = check_codec(arguments.query.codec, is_glb); !fits) {
    throw ExitError(kUsage, "--" + fits.error().text);
  }
}

std::vector<std::string> larger_file_notice(const std::string& file, std::uint64_t max_bytes) {
  std::error_code ignored;
  const std::uintmax_t bytes = std::filesystem::file_size(file, ignored);
  if (max_bytes == 0 || ignored || bytes <= max_bytes) return {};
  return {file + " has " + human_bytes(bytes) + ", more than --max-bytes, which bounds the " +
          "surface as it is sent; --max-triangles bounds files."};
}

}  // namespace multitetra
