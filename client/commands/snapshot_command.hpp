// `multitetra-client snapshot`: draws surfaces into a picture file, without a display.
#pragma once

#include <string>
#include <vector>

#include "client/commands/connected_request.hpp"
#include "common/cli/command.hpp"
#include "common/picture/camera.hpp"

namespace multitetra {

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
  int threads = 0;
  bool json = false;
};

void add_snapshot(Command& app, SnapshotArguments& arguments);

struct PictureSize {
  int width = 0;
  int height = 0;
};

// Parses "1280x960". Returns kInvalidArgument for anything else and above kMaxPictureSide.
[[nodiscard]] Result<PictureSize> parse_picture_size(const std::string& text);

// Returns the exit code.
[[nodiscard]] int snapshot(const SnapshotArguments& arguments);

}  // namespace multitetra
