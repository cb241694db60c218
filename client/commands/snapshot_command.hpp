// `multitetra-client snapshot`: a picture of surfaces, without a display.
#pragma once

#include <string>
#include <vector>

#include "client/commands/connected_request.hpp"
#include "client/picture/camera.hpp"
#include "common/cli/command.hpp"

namespace multitetra {

struct SnapshotArguments {
  SurfaceOrder order;
  std::string picture;
  std::string size = "1280x960";  // WIDTHxHEIGHT in pixels.
  double azimuth = kDefaultAzimuth;
  double elevation = kDefaultElevation;
  std::string up = "z";  // As up_axis_from() reads it.
  std::string background = "dark";
  std::string shading = "smooth";
  bool wireframe = false;
  bool is_bare = false;  // Nothing is written on the picture.
  // The opacities of the surfaces, in the order of their isovalues.
  std::vector<double> opacities = {};
  std::vector<std::string> surface_colors = {};  // "#rrggbb", likewise.
  int threads = 0;
  bool json = false;
  bool quiet = false;
};

void add_snapshot(Command& app, SnapshotArguments& arguments);

struct PictureSize {
  int width = 0;
  int height = 0;
};

// "1280x960"; kInvalidArgument for anything else and beyond kMaxPictureSide.
[[nodiscard]] Result<PictureSize> parse_picture_size(const std::string& text);

// Gives the exit code.
[[nodiscard]] int snapshot(const SnapshotArguments& arguments);

}  // namespace multitetra
