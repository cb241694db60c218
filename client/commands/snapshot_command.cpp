// `multitetra-client snapshot`: draws surfaces into a picture file, without a display.
#include <algorithm>
#include <chrono>
#include <iostream>
#include <iterator>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "client/commands/commands.hpp"
#include "client/commands/snapshot_scenes.hpp"
#include "client/commands/snapshot_volume.hpp"
#include "common/base/exit_codes.hpp"
#include "common/base/json.hpp"
#include "common/base/number_text.hpp"
#include "common/base/parse_number.hpp"
#include "common/cli/human_units.hpp"
#include "common/cli/output_files.hpp"
#include "common/image/png_file.hpp"
#include "common/json/json_report.hpp"
#include "common/picture/annotations.hpp"
#include "common/picture/camera.hpp"
#include "common/picture/rasterizer.hpp"
#include "common/request/request_notices.hpp"

namespace multitetra {
namespace {

struct SnapshotArguments {
  SurfaceOrder order;
  std::string picture;
  std::string size = "1280x960";  // WIDTHxHEIGHT in pixels.
  double azimuth = kDefaultAzimuth;
  double elevation = kDefaultElevation;
  std::string up = "z";  // See up_axis_from().
  std::string background = "dark";
  std::string shading = "field";
  bool wireframe = false;
  // Omits scale bar and legend.
  bool is_bare = false;
  // Opacities in the order of the isovalues.
  std::vector<double> opacities = {};
  std::vector<std::string> surface_colors = {};  // "#rrggbb", in the same order.
  VolumeArguments volume = {};
  int threads = 0;
  bool json = false;
};

struct PictureSize {
  int width = 0;
  int height = 0;
};

Background background_from(const std::string& word) {
  if (word == "light") return Background::kLight;
  return word == "transparent" ? Background::kTransparent : Background::kDark;
}

Json surface_json(const TakenSurface& surface) {
  SurfaceReport report = surface.part.report;
  report.notices = surface.part.notices->texts();
  report.more = {{"bytes", surface.bytes}};
  return json_of(report);
}

Json report_of(const SnapshotArguments& arguments, const Endpoint& server, const Scene& scene,
               const PictureSize& size, const Taken& taken) {
  Json json = {{"server", to_string(server)}};
  if (taken.surfaces.size() == 1) {
    json.update(surface_json(taken.surfaces.front()));
  } else {
    json["notices"] = Json::array();
    for (const DatasetRequest& dataset : scene.datasets) {
      for (const std::string& text : dataset.notices.texts()) json["notices"].push_back(text);
    }
    json["surfaces"] = Json::array();
    for (const TakenSurface& each : taken.surfaces) json["surfaces"].push_back(surface_json(each));
  }
  json.update({{"picture_file", scene.picture_file},
               {"width", size.width},
               {"height", size.height},
               {"azimuth", arguments.azimuth},
               {"elevation", arguments.elevation},
               {"up", arguments.up},
               {"background", arguments.background},
               {"shading", arguments.shading},
               {"wireframe", arguments.wireframe},
               {"fetch_seconds", taken.fetch_seconds},
               {"draw_seconds", taken.draw_seconds}});
  if (taken.volume) {
    json["volume"] = {{"mode", arguments.volume.mode},
                      {"samples", taken.volume->drawn.values.size()},
                      {"step", taken.volume->step}};
  }
  return json;
}

void print(const Scene& scene, const PictureSize& size, const Taken& taken) {
  std::set<double> isovalues;
  for (const TakenSurface& surface : taken.surfaces)
    isovalues.insert(surface.part.report.request.isovalue);
  std::string text;
  for (const double one : isovalues) text += (text.empty() ? "" : ",") + shortest_text(one);
  std::cout << scene.picture_file << ": ";
  if (taken.volume) {
    std::cout << "volume of " << human_count_of(taken.volume->drawn.values.size(), "sample")
              << (taken.volume->step > 1
                      ? ", 1 in " + std::to_string(taken.volume->step) + " per axis, "
                      : ", ");
  }
  if (!text.empty()) {
    std::cout << human_count_of(taken.surfaces.size(), "surface") << ", isovalue " << text << ", ";
  }
  std::cout << size.width << " x " << size.height << " pixels, "
            << human_count_of(taken.triangles(), "triangle") << ", " << human_bytes(taken.bytes())
            << " fetched in " << human_seconds(taken.fetch_seconds) << ", drawn in "
            << human_seconds(taken.draw_seconds) << "\n";
}

// Returns the vertices of large components, for framing: dust would shift the center.
std::vector<Vec3> middle_of(const Taken& taken) {
  std::vector<Vec3> points;
  for (const TakenSurface& surface : taken.surfaces) {
    for (const std::uint32_t vertex : surface.part.surface.large) {
      points.push_back(surface.part.surface.mesh.positions[vertex]);
    }
  }
  return points;
}

// Returns the corners of the data, which are the same at all times.
std::vector<Vec3> corners_of(const DatasetInfo& info, const Affine& to_output) {
  std::vector<Vec3> corners;
  for (unsigned corner = 0; corner < 8; ++corner) {
    Vec3 at = {};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      at[axis] = (corner >> axis & 1U) != 0 ? info.dims[axis] - 1 : 0;
    }
    corners.push_back(to_output(at));
  }
  return corners;
}

// Draws the scale bar and the color legend.
void annotate(Picture& picture, const Camera& camera, const DatasetRequest& surface,
              const Taken& taken, const SnapshotArguments& arguments) {
  const Background background = background_from(arguments.background);
  const bool is_world = arguments.order.surface.query.coordinates == CoordinateSystem::kWorld;
  draw_scale_bar(picture, camera, is_world ? surface.info.meaning.length_unit : "samples",
                 background);
  const auto colored =
      std::find_if(taken.surfaces.begin(), taken.surfaces.end(),
                   [](const TakenSurface& each) { return each.colors.has_value(); });
  if (colored != taken.surfaces.end()) {
    draw_legend(picture,
                {.scale = *colored->colors,
                 .name = arguments.order.surface.query.color_by,
                 .unit = surface.color_unit},
                background);
  } else if (taken.volume) {
    draw_legend(picture,
                {.scale = taken.volume->drawn.colors,
                 .name = surface.info.name,
                 .unit = surface.info.meaning.value_unit},
                background);
  }
}

// Draws a scene into its file. The pictures of several times all show the whole data.
void draw(const SnapshotArguments& arguments, const Scene& scene, const PictureSize& size,
          bool is_one_of_times, std::vector<DrawnSurface> appearances, Taken& taken) {
  const auto came = std::chrono::steady_clock::now();
  const DatasetRequest& first = scene.datasets.front();
  const std::vector<Vec3> points =
      is_one_of_times || taken.volume
          ? corners_of(first.info, index_to_output(arguments.order.surface, first.info))
          : middle_of(taken);
  const Camera camera = framing(points, arguments.azimuth, arguments.elevation, size.width,
                                size.height, up_axis_from(arguments.up).value());
  for (std::size_t i = 0; i < appearances.size(); ++i)
    appearances[i].mesh = &taken.surfaces[i].part.surface.mesh;
  Picture picture =
      drawn(appearances, camera,
            {.background = background_from(arguments.background),
             .shading = arguments.shading == "facets" ? Shading::kFlat : Shading::kSmooth,
             .wireframe = arguments.wireframe,
             .volume = taken.volume ? &taken.volume->drawn : nullptr,
             .threads = arguments.threads});
  if (!arguments.is_bare) annotate(picture, camera, first, taken, arguments);
  taken.draw_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - came).count();
  write_file(scene.picture_file, png_file(picture));
}

constexpr const char* kSnapshotExamples =
    "The same surface, size and direction give the same picture, byte for byte.\n"
    "Examples:\n"
    "  multitetra-client snapshot --dataset head --isovalue 500.5 -o head.png\n"
    "  multitetra-client snapshot --dataset head --isovalue 1200.5 --error 0.5 "
    "--size 3840x2160 --azimuth 90 --elevation 0 -o bone.png\n"
    "  multitetra-client snapshot --dataset head --isovalue 500.5,1200.5 --opacity 0.4,1 "
    "-o skin_and_bone.png\n"
    "  multitetra-client snapshot --dataset organs -o organs.png    (a series: all labels)\n"
    "  multitetra-client snapshot --dataset head --volume on -o volume.png\n"
    "  multitetra-client snapshot --dataset head --error 2 --wireframe --shading facets "
    "-o triangles.png\n"
    "  multitetra-client snapshot --server wss://example.org --token-file token "
    "--dataset head --background transparent -o head.png\n";

void add_drawing_options(Command& command, SnapshotArguments& a) {
  command.begin_group("Picture");
  command.add_option("--up", a.up, "World axis that points up in the picture, such as -y")
      ->one_of({"x", "-x", "y", "-y", "z", "-z"})
      ->capture_default_str();
  command.add_option("--background", a.background, "Background of the picture")
      ->one_of({"dark", "light", "transparent"})
      ->capture_default_str();
  command.add_option("--shading", a.shading, "field: by the field's gradient; facets: by triangle")
      ->one_of({"field", "facets"})
      ->capture_default_str();
  command.add_flag("--bare", a.is_bare, "Omit the scale bar and the color legend");
  command.add_flag("--wireframe", a.wireframe, "Also draw the edges of the triangles");
  command
      .add_option(
          "--opacity", a.opacities,
          "Opacity of the surfaces, above 0 and at most 1: one for all, or one for each with "
          "commas between them (default: 1)")
      ->repeatable()
      ->delimiter(',')
      ->type_name("FLOAT,...");
  command
      .add_option(
          "--surface-color", a.surface_colors,
          "Color of the surfaces, as #dd8265: one for all, or one for each with commas between "
          "them")
      ->repeatable()
      ->delimiter(',')
      ->type_name("COLOR,...");
  command.add_option("--threads", a.threads, "Threads for drawing (default: one per processor)")
      ->within(1, 1024);
}

// Parses "1280x960". Returns kInvalidArgument for anything else and above kMaxPictureSide.
Result<PictureSize> parse_picture_size(const std::string& text) {
  const auto sides = parse_numbers<int>(text, 2, 'x');
  const auto is_side = [](int n) { return n >= 1 && n <= kMaxPictureSide; };
  if (!sides || !is_side(sides->front()) || !is_side(sides->back())) {
    return fail(ErrorCode::kInvalidArgument,
                "--size: \"" + text +
                    "\" is not a picture size; write for example 1280x960, with sides of 1 to " +
                    std::to_string(kMaxPictureSide) + " pixels.");
  }
  return PictureSize{.width = sides->front(), .height = sides->back()};
}

int snapshot(const SnapshotArguments& arguments) {
  require_codec(arguments.order.surface, /*is_glb=*/false);
  if (!arguments.picture.ends_with(".png")) {
    throw ExitError(kUsage,
                    "\"" + arguments.picture + "\" is not a PNG file name; pictures are *.png.");
  }
  const PictureSize size = value_or_usage_error(parse_picture_size(arguments.size));
  if (const auto fits = check(arguments.volume); !fits) throw ExitError(kUsage, fits.error().text);
  require_outputs({{"--output", arguments.picture}},
                  {{"--threshold-grid", arguments.order.surface.threshold_grid}});
  ConnectedRequests connected = ordered_datasets(arguments.order);
  if (arguments.volume.is_shown() && arguments.order.surface.query.isovalues.empty()) {
    for (DatasetRequest& dataset : connected.datasets) {
      const bool is_label = dataset.info.member && dataset.info.member->label;
      if (!is_label) dataset.requests.clear();  // The volume alone.
    }
  }
  share_budget(connected);
  const std::vector<Scene> scenes = scenes_of(arguments.picture, connected);
  const bool are_several = scenes.size() > 1;
  Json reports = Json::array();
  bool is_empty = true;
  for (const Scene& scene : scenes) {
    std::vector<DrawnSurface> appearances = value_or_usage_error(
        appearances_of(arguments.opacities, arguments.surface_colors, scene.datasets));
    Taken taken = taken_from(arguments.order, arguments.volume, connected.client, scene);
    const std::size_t empty = taken.empty_surfaces();
    const bool shows_something = taken.volume || empty < taken.surfaces.size();
    is_empty &= !shows_something;
    // Some labels and times of a series may be empty.
    const bool is_complete = connected.is_series ? are_several || shows_something : empty == 0;
    const bool is_drawn = is_complete || arguments.order.surface.allow_empty;
    if (is_drawn) draw(arguments, scene, size, are_several, std::move(appearances), taken);
    reports.push_back(report_of(arguments, connected.server, scene, size, taken));
    if (is_drawn && !arguments.json && !arguments.order.quiet) print(scene, size, taken);
    if (!is_drawn) is_empty = true;
  }
  if (arguments.json) {
    std::cout << text_of(are_several ? Json{{"pictures", reports}} : reports.front());
  }
  if (is_empty && !arguments.order.surface.allow_empty) {
    throw ExitError(kEmptySurface, not_written_text(arguments.picture));
  }
  return kOk;
}

}  // namespace

void add_snapshot(Command& program, Run& run) {
  const auto a = std::make_shared<SnapshotArguments>();
  Command* command = program.add_subcommand(
      "snapshot", "Fetch isosurfaces and draw them into a PNG file, without a display");
  command->add_option("-o,--output", a->picture, "Picture to write (.png)")
      ->required()
      ->type_name("FILE");
  command->add_option("--size", a->size, "Width and height in pixels")
      ->type_name("WxH")
      ->capture_default_str();
  command
      ->add_option("--azimuth", a->azimuth,
                   "Degrees around the z axis; 0 looks along +y (at a patient's face), 90 along -x")
      ->within(-3600.0, 3600.0)
      ->type_name("DEGREES")
      ->capture_default_str();
  command->add_option("--elevation", a->elevation, "Degrees: -90 looks from below, 90 from above")
      ->within(-90.0, 90.0)
      ->type_name("DEGREES")
      ->capture_default_str();
  add_drawing_options(*command, *a);
  add_volume_options(*command, a->volume);
  command->begin_group();
  // Averaged triangle normals show creases in a picture; the field's normals are smooth.
  a->order.surface.query.request.normal_bits = kMinNormalBits;
  add_order_options(
      *command, a->order,
      {FieldGroup::kSurface, FieldGroup::kThresholds, FieldGroup::kSize, FieldGroup::kColors});
  command->option("--normals").default_text(std::to_string(kMinNormalBits));
  add_output_options(*command, a->order.surface);
  command->begin_group("Reports");
  command->add_flag("--json", a->json, "Print a JSON report");
  command->add_flag("--quiet", a->order.quiet, "Print errors only");
  command->footer(std::string(kSnapshotExamples) + kExitCodes);
  command->callback([a, &run] { run = [a] { return snapshot(*a); }; });
}

}  // namespace multitetra
