#include "client/commands/snapshot_command.hpp"

#include <charconv>
#include <chrono>
#include <iostream>
#include <string_view>

#include <nlohmann/json.hpp>

#include "client/picture/rasterizer.hpp"
#include "common/cli/human_units.hpp"
#include "common/cli/json_report.hpp"
#include "common/cli/output_files.hpp"
#include "common/image/png_file.hpp"
#include "common/request/request_notices.hpp"
#include "common/wire/mesh_files.hpp"

namespace multitetra {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

Background background_from(const std::string& word) {
  if (word == "light") return Background::kLight;
  return word == "transparent" ? Background::kTransparent : Background::kDark;
}

// What came and how long it took.
struct Taken {
  MeshTopology topology;
  std::uint64_t bytes = 0;
  double error_bound_world = 0;
  double fetch_seconds = 0;
  double draw_seconds = 0;
};

Json report_of(const SnapshotArguments& arguments, const OrderedSurface& surface,
               const PictureSize& size, const Taken& taken) {
  return {{"server", to_string(surface.server)},
          {"dataset", surface.info.name},
          {"parameters", json_of(surface.request)},
          {"error_bound_world", taken.error_bound_world},
          {"notices", surface.notices.told()},
          {"is_empty", taken.topology.triangles == 0},
          {"triangles", taken.topology.triangles},
          {"bytes", taken.bytes},
          {"picture_file", arguments.picture},
          {"width", size.width},
          {"height", size.height},
          {"azimuth", arguments.azimuth},
          {"elevation", arguments.elevation},
          {"background", arguments.background},
          {"shading", arguments.shading},
          {"wireframe", arguments.wireframe},
          {"fetch_seconds", taken.fetch_seconds},
          {"draw_seconds", taken.draw_seconds}};
}

void print(const SnapshotArguments& arguments, const PictureSize& size, const Taken& taken) {
  std::cout << arguments.picture << ": " << size.width << " x " << size.height << " pixels, "
            << human_count(static_cast<std::uint64_t>(taken.topology.triangles)) << " triangles, "
            << human_bytes(taken.bytes) << " fetched in " << human_seconds(taken.fetch_seconds)
            << ", drawn in " << human_seconds(taken.draw_seconds) << "\n";
}

}  // namespace

Result<PictureSize> parse_picture_size(const std::string& text) {
  PictureSize size;
  const char* const end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, size.width);
  const bool has_width = width.ec == std::errc() && width.ptr != end && *width.ptr == 'x';
  const auto height = std::from_chars(has_width ? width.ptr + 1 : end, end, size.height);
  const auto is_side = [](int n) { return n >= 1 && n <= kMaxPictureSide; };
  if (!has_width || height.ec != std::errc() || height.ptr != end || !is_side(size.width) ||
      !is_side(size.height)) {
    return fail(ErrorCode::kInvalidArgument,
                "--size: \"" + text +
                    "\" is no size of a picture; one looks like 1280x960, with "
                    "sides of 1 to " +
                    std::to_string(kMaxPictureSide) + " pixels.");
  }
  return size;
}

int snapshot(const SnapshotArguments& arguments) {
  if (!arguments.picture.ends_with(".png")) {
    return complain(kUsage, "\"" + arguments.picture +
                                "\" is no name of a picture; pictures are PNG files, *.png.");
  }
  const auto size = parse_picture_size(arguments.size);
  if (!size) return complain(kUsage, size.error().text);
  const auto scalars = scalars_of(arguments.colors);
  if (!scalars) return complain(kUsage, scalars.error().text);
  require_outputs({{"--output", arguments.picture}},
                  {{"--threshold-grid", arguments.order.surface.threshold_grid}});
  auto surface = ordered(arguments.order);
  if (!surface) return surface.error();
  Taken taken;
  const auto asked = Clock::now();
  const auto fetched = surface->client.fetch(surface->info,
                                             {.dataset = surface->info.name,
                                              .request = surface->request,
                                              .steps = StepPolicy::kFinalOnly,
                                              .held = {},
                                              .scalars = *scalars},
                                             [](const FetchedStep&) {});
  if (!fetched) return complain(fetched.error());
  taken.fetch_seconds = seconds_since(asked);
  const CommittedStep& step = *fetched->step;
  taken.topology = step.topology;
  taken.bytes = step.end.payload_bytes;
  taken.error_bound_world = step.begin.error_bound_world;

  if (taken.topology.triangles == 0) {
    surface->notices.tell(empty_surface_text(surface->request, surface->info));
    if (!arguments.order.surface.allow_empty) {
      if (arguments.json) std::cout << text_of(report_of(arguments, *surface, *size, taken));
      return complain(kEmptySurface, not_written_text(arguments.picture));
    }
  }
  const auto came = Clock::now();
  OutputSurface drawn_surface = output_surface(step.mesh, arguments.order.surface, surface->info);
  paint(drawn_surface.mesh, step.begin, arguments.colors);
  const std::string accuracy = accuracy_text(step);
  if (!accuracy.empty() && !arguments.quiet) std::cerr << accuracy << std::endl;
  const std::string left_out = left_out_text(drawn_surface, arguments.order.surface);
  if (!left_out.empty()) surface->notices.tell("The picture has " + left_out + ".");
  // Dust around the largest component would push it out of the middle.
  std::vector<std::array<float, 3>> largest;
  for (const std::uint32_t vertex : drawn_surface.largest) {
    largest.push_back(drawn_surface.mesh.positions[vertex]);
  }
  const Camera camera =
      framing(largest, arguments.azimuth, arguments.elevation, size->width, size->height);
  const Picture picture =
      drawn(drawn_surface.mesh, camera,
            {.background = background_from(arguments.background),
             .shading = arguments.shading == "flat" ? Shading::kFlat : Shading::kSmooth,
             .wireframe = arguments.wireframe,
             .threads = arguments.threads});
  taken.draw_seconds = seconds_since(came);
  write_file(arguments.picture, png_file(picture));
  if (arguments.json) {
    std::cout << text_of(report_of(arguments, *surface, *size, taken));
  } else if (!arguments.quiet) {
    print(arguments, *size, taken);
  }
  return kOk;
}

void add_snapshot(Command& app, SnapshotArguments& a) {
  Command* command = app.add_subcommand(
      "snapshot", "Fetch an isosurface and draw it into a PNG file, without a display");
  command->add_option("-o,--output", a.picture, "Picture to write (.png)")
      ->required()
      ->type_name("FILE");
  const std::string group = "Picture";
  command->add_option("--size", a.size, "Width and height in pixels")
      ->type_name("WxH")
      ->capture_default_str()
      ->group(group);
  command
      ->add_option("--azimuth", a.azimuth,
                   "Degrees around the z axis: 0 looks along +y, as at a patient's face, 90 along "
                   "-x")
      ->within(-3600.0, 3600.0)
      ->type_name("DEGREES")
      ->capture_default_str()
      ->group(group);
  command->add_option("--elevation", a.elevation, "Degrees: -90 looks from below, 90 from above")
      ->within(-90.0, 90.0)
      ->type_name("DEGREES")
      ->capture_default_str()
      ->group(group);
  command->add_option("--background", a.background, "What is behind the surface")
      ->one_of({"dark", "light", "transparent"})
      ->capture_default_str()
      ->group(group);
  command->add_option("--shading", a.shading, "smooth: by the field's gradient; flat: by triangle")
      ->one_of({"smooth", "flat"})
      ->capture_default_str()
      ->group(group);
  command->add_flag("--wireframe", a.wireframe, "Draw the edges of the triangles as well")
      ->group(group);
  command->add_option("--threads", a.threads, "For drawing (default: one per processor)")
      ->within(1, 1024)
      ->group(group);
  // A picture shows creases where the triangles' own normals are averaged: the field's are smooth.
  a.order.surface.normal_bits = kMinNormalBits;
  add_order_options(*command, a.order);
  add_output_options(*command, a.order.surface);
  add_color_options(*command, a.colors);
  command->add_flag("--json", a.json, "Print a JSON report");
  command->add_flag("--quiet", a.quiet, "Say nothing unless something is wrong");
  command->footer(
      std::string(
          "The same surface, size and direction give the same picture, byte for byte.\n"
          "Examples:\n"
          "  multitetra-client snapshot --dataset head --isovalue 500.5 -o head.png\n"
          "  multitetra-client snapshot --dataset head --isovalue 1200.5 --error 0.5 "
          "--size 3840x2160 --azimuth 90 --elevation 0 -o bone.png\n"
          "  multitetra-client snapshot --dataset head --error 2 --wireframe --shading flat "
          "-o triangles.png\n"
          "  multitetra-client snapshot --server wss://example.org --token-file token "
          "--dataset head --background transparent -o head.png\n") +
      kExitCodes);
}

}  // namespace multitetra
