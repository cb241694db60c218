// Rendering pictures without a display.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/image/png_file.hpp"
#include "common/picture/annotations.hpp"
#include "common/picture/camera.hpp"
#include "common/picture/canvas.hpp"
#include "common/picture/rasterizer.hpp"
#include "common/picture/shading.hpp"

namespace multitetra {
namespace {

// A ball of radius 1 around `middle` with outward triangles and `rings` rings from pole to pole.
PositionedMesh ball(const Vec3& middle, int rings = 24) {
  PositionedMesh mesh;
  const int around = 2 * rings;
  for (int i = 0; i <= rings; ++i) {
    for (int j = 0; j < around; ++j) {
      const double theta = std::numbers::pi * i / rings;
      const double phi = 2 * std::numbers::pi * j / around;
      mesh.positions.push_back({middle[0] + std::sin(theta) * std::cos(phi),
                                middle[1] + std::sin(theta) * std::sin(phi),
                                middle[2] + std::cos(theta)});
    }
  }
  const auto vertex = [around](int i, int j) {
    return static_cast<std::uint32_t>(i * around + j % around);
  };
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < around; ++j) {
      mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
      mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
    }
  }
  return mesh;
}

PositionedMesh joined(PositionedMesh mesh, const PositionedMesh& other) {
  const auto shift = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  for (const TriangleIndices& t : other.triangles) {
    mesh.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
  }
  return mesh;
}

Picture picture_of(const PositionedMesh& mesh, double azimuth, double elevation,
                   const DrawOptions& options = {}, int width = 160, int height = 120) {
  return drawn(mesh, framing(mesh.positions, azimuth, elevation, width, height), options);
}

int brightness(const Pixel& pixel) { return pixel[0] + pixel[1] + pixel[2]; }

// Pixels covered wholly or partly by the surface, on a transparent background.
struct Covered {
  double share = 0;
  double x = 0;  // The centroid, from 0 to 1.
  double y = 0;
};
Covered covered(const Picture& picture) {
  Covered found;
  double sum = 0;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const double weight = picture.at(x, y)[3] / 255.0;
      sum += weight;
      found.x += weight * (x + 0.5) / picture.width;
      found.y += weight * (y + 0.5) / picture.height;
    }
  }
  found.x /= sum;
  found.y /= sum;
  found.share = sum / (picture.width * picture.height);
  return found;
}

TEST(Picture, CentersTheWholeSurface) {
  const Picture picture =
      picture_of(ball({5, -7, 100}), 30, 15, {.background = Background::kTransparent});
  const Covered found = covered(picture);
  EXPECT_NEAR(found.x, 0.5, 0.01);
  EXPECT_NEAR(found.y, 0.5, 0.01);
  EXPECT_GT(found.share, 0.45);  // The ball fills nine tenths of the height.
  EXPECT_LT(found.share, 0.55);
  EXPECT_EQ(picture.at(0, 0)[3], 0);
  EXPECT_EQ(picture.at(80, 60)[3], 255);
}

TEST(Picture, HasNoHolesInAClosedSurface) {
  const Picture picture =
      picture_of(ball({0, 0, 0}), 10, 40, {.background = Background::kTransparent});
  for (int y = 0; y < picture.height; ++y) {
    int first = picture.width;
    int last = -1;
    for (int x = 0; x < picture.width; ++x) {
      if (picture.at(x, y)[3] != 255) continue;
      first = std::min(first, x);
      last = x;
    }
    for (int x = first; x <= last; ++x) ASSERT_EQ(picture.at(x, y)[3], 255) << x << " " << y;
  }
}

TEST(Picture, HasSmoothEdges) {
  const Picture picture =
      picture_of(ball({0, 0, 0}), 0, 0, {.background = Background::kTransparent});
  int partly = 0;
  for (const Pixel& pixel : picture.pixels) partly += pixel[3] > 0 && pixel[3] < 255 ? 1 : 0;
  EXPECT_GT(partly, 150);
}

TEST(Picture, ShowsTheNearestTriangleInAnyOrder) {
  // Along +y the first ball hides the second; seen from behind, the second hides the first.
  const PositionedMesh small = ball({0, -3, 0}, 8);
  PositionedMesh large = ball({0, 3, 0});
  for (const bool small_first : {true, false}) {
    const PositionedMesh both = small_first ? joined(small, large) : joined(large, small);
    const Picture front = picture_of(both, 0, 0);
    const Picture alone = drawn(small, framing(both.positions, 0, 0, 160, 120), {});
    EXPECT_EQ(front.at(80, 60), alone.at(80, 60));
    const Picture behind = picture_of(both, 180, 0);
    const Picture other = drawn(large, framing(both.positions, 180, 0, 160, 120), {});
    EXPECT_EQ(behind.at(80, 60), other.at(80, 60));
  }
}

TEST(Picture, ClipsTrianglesBehindOrBesideTheEye) {
  const PositionedMesh middle = ball({0, 0, 0});
  const Camera camera = framing(middle.positions, 0, 0, 160, 120);  // The eye is at -y.
  const Picture alone = drawn(middle, camera, {});
  const double eye = camera.eye[1];
  for (const Vec3& place :
       {Vec3{0, eye - 5, 0}, {0, eye, 50}, {1e30, 0, 0}, {-1e5, 5, -1e5}, {0, 0, 1e4}}) {
    EXPECT_EQ(drawn(joined(middle, ball(place, 8)), camera, {}).pixels, alone.pixels);
  }
}

TEST(Picture, LightsSurfacesFromTheEye) {
  const Picture picture = picture_of(ball({0, 0, 0}), 200, -30);
  EXPECT_GT(brightness(picture.at(80, 60)), 400);
  // The ball is darker towards its edges; the light is at the upper left.
  EXPECT_GT(brightness(picture.at(80, 60)), brightness(picture.at(80, 108)) + 100);
  EXPECT_GT(brightness(picture.at(60, 40)), brightness(picture.at(100, 80)));
}

TEST(Picture, ShowsTheInsideDarker) {
  PositionedMesh turned = ball({0, 0, 0});
  for (TriangleIndices& triangle : turned.triangles) std::swap(triangle[1], triangle[2]);
  const int outside = brightness(picture_of(ball({0, 0, 0}), 0, 0).at(80, 60));
  const int inside = brightness(picture_of(turned, 0, 0).at(80, 60));
  EXPECT_LT(inside, outside - 100);
}

TEST(Picture, UsesTheNormalsOfTheMesh) {
  PositionedMesh facets = ball({0, 0, 0}, 6);
  const Picture computed = picture_of(facets, 0, 0);
  for (const auto& [x, y, z] : facets.positions) {
    facets.normals.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
  }
  const Picture sent = picture_of(facets, 0, 0);
  EXPECT_NE(computed.pixels, sent.pixels);
  for (UnitVector& normal : facets.normals) normal = {0, 1, 0};  // All facing away from the eye.
  const int unlit = brightness(picture_of(facets, 0, 0).at(80, 60));
  EXPECT_LT(unlit, brightness(sent.at(80, 60)) - 100);
}

TEST(Picture, RotatesByItsAngles) {
  // An object on the +x side appears at the right from the front, and in the middle from +x.
  const PositionedMesh lopsided = joined(ball({0, 0, 0}), ball({4, 0, 0}, 4));
  const DrawOptions transparent = {.background = Background::kTransparent};
  const Camera front = framing(lopsided.positions, 0, 0, 160, 120);
  EXPECT_GT(front.seen({4, 0, 0})[0], front.seen({0, 0, 0})[0] + 3.9);
  const Camera side = framing(lopsided.positions, 90, 0, 160, 120);
  EXPECT_NEAR(side.seen({4, 0, 0})[0], side.seen({0, 0, 0})[0], 1e-9);
  EXPECT_GT(side.seen({4, 0, 0})[2], side.seen({0, 0, 0})[2] + 3.9);  // Nearer to the eye.
  const Camera above = framing(lopsided.positions, 0, 90, 160, 120);
  EXPECT_GT(above.seen({0, 0, 1})[2], above.seen({0, 0, 0})[2] + 0.9);
  EXPECT_GT(above.seen({0, 1, 0})[1], above.seen({0, 0, 0})[1] + 0.9);
  EXPECT_GT(covered(drawn(lopsided, front, transparent)).share,
            covered(drawn(lopsided, side, transparent)).share * 0.2);
}

// A roof with two triangles per side and its ridge along z, seen from the front.
PositionedMesh roof() {
  return {.positions = {{-1, 0, -1}, {0, -1, -1}, {1, 0, -1}, {-1, 0, 1}, {0, -1, 1}, {1, 0, 1}},
          .triangles = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}}};
}

TEST(Framing, RotatesWithTheUpAxis) {
  const PositionedMesh mesh = ball({3, -2, 5});
  const Camera upright = framing(mesh.positions, 20, 10, 160, 120);
  for (const char* axis : {"x", "-x", "y", "-y", "z", "-z"}) {
    const Vec3 up = up_axis_from(axis).value();
    const Camera camera = framing(mesh.positions, 20, 10, 160, 120, up);
    // The view's elevation and handedness do not depend on the up axis.
    EXPECT_NEAR(dot(camera.up, up), upright.up[2], 1e-12) << axis;
    EXPECT_NEAR(dot(camera.back, up), upright.back[2], 1e-12) << axis;
    EXPECT_NEAR(dot(camera.right, up), 0, 1e-12) << axis;
    const Vec3 right = cross(camera.up, camera.back);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(right[i], camera.right[i], 1e-12) << axis;
  }
  // Rotated from z to -y like the viewer (three.js): looks along z where z-up looks along y.
  const Camera along_z = framing(mesh.positions, 0, 0, 160, 120, {0, -1, 0});
  EXPECT_NEAR(along_z.back[2], -1, 1e-12);
  EXPECT_NEAR(along_z.right[0], 1, 1e-12);
}

TEST(Framing, AcceptsOnlySignedAxes) {
  EXPECT_EQ(up_axis_from("-y"), (Vec3{0, -1, 0}));
  for (const char* text : {"", "-", "w", "xy", "--x", "0"})
    EXPECT_FALSE(up_axis_from(text)) << text;
}

TEST(Picture, ShowsRidgesOnlyInFlatShading) {
  const auto step_at_ridge = [](const DrawOptions& options) {
    const Picture picture = picture_of(roof(), 0, 0, options);
    return std::abs(brightness(picture.at(78, 60)) - brightness(picture.at(82, 60)));
  };
  EXPECT_GT(step_at_ridge({.shading = Shading::kFlat}), 100);
  EXPECT_LT(step_at_ridge({.shading = Shading::kSmooth}), 30);
}

TEST(Picture, IgnoresNormalsInFlatShading) {
  PositionedMesh mesh = roof();
  const Picture without = picture_of(mesh, 20, 10, {.shading = Shading::kFlat});
  mesh.normals.assign(mesh.positions.size(), UnitVector{0, 1, 0});
  EXPECT_EQ(picture_of(mesh, 20, 10, {.shading = Shading::kFlat}).pixels, without.pixels);
}

TEST(Picture, DrawsWiresOnlyAlongEdges) {
  const DrawOptions flat = {.shading = Shading::kFlat};
  const DrawOptions wired = {.shading = Shading::kFlat, .wireframe = true};
  const Picture surface = picture_of(roof(), 0, 0, flat);
  const Picture wires = picture_of(roof(), 0, 0, wired);
  const auto is_wire = [&](int x, int y) {
    return brightness(wires.at(x, y)) < brightness(surface.at(x, y)) - 100;
  };
  const auto [left, right, above, below] = std::array{26, 134, 20, 100};  // Inside the outline.
  int diagonals = 0;
  int dark = 0;
  for (int y = above; y < below; ++y) {
    EXPECT_TRUE(is_wire(79, y) || is_wire(80, y)) << y;  // The ridge.
    for (int x = left; x < right; ++x) dark += is_wire(x, y) ? 1 : 0;
    int in_row = 0;
    for (int x = left; x < 77; ++x) in_row += is_wire(x, y) ? 1 : 0;
    diagonals += in_row > 0 ? 1 : 0;
    EXPECT_LE(in_row, 4) << y;
  }
  EXPECT_GT(diagonals, below - above - 10);
  EXPECT_LT(dark, (right - left) * (below - above) / 12);
}

TEST(Picture, FadesWiresOfSmallTriangles) {
  const auto darkening = [](int rings) {
    const PositionedMesh mesh = ball({0, 0, 0}, rings);
    const int plain = brightness(picture_of(mesh, 0, 0).at(75, 55));
    int darkest = plain;
    const Picture wired = picture_of(mesh, 0, 0, {.wireframe = true});
    for (int y = 50; y < 60; ++y) {
      for (int x = 70; x < 80; ++x) darkest = std::min(darkest, brightness(wired.at(x, y)));
    }
    return plain - darkest;
  };
  EXPECT_GT(darkening(12), 200);
  EXPECT_LT(darkening(200), 60);
}

// A ball inside another, translucent ball.
class NestedBalls : public ::testing::Test {
 protected:
  [[nodiscard]] Picture drawn_with(std::vector<DrawnSurface> surfaces,
                                   DrawOptions options = {}) const {
    return drawn(surfaces, camera_, options);
  }
  [[nodiscard]] static Light middle_of(const Picture& picture) {
    const Pixel& pixel = picture.at(80, 60);
    return linear_light(Rgb{pixel[0], pixel[1], pixel[2]});
  }

  PositionedMesh inner_ = ball({0, 0, 0});
  PositionedMesh outer_ = [this] {
    PositionedMesh mesh = inner_;
    for (auto& position : mesh.positions) {
      for (double& coordinate : position) coordinate *= 2;
    }
    return mesh;
  }();
  Camera camera_ = framing(outer_.positions, 20, 30, 160, 120);
  Light red_ = {0.8F, 0.2F, 0.1F};
};

TEST_F(NestedBalls, BlendByOpacity) {
  const Light outer = middle_of(drawn_with({{.mesh = &outer_, .color = red_}}));
  const Light inner = middle_of(drawn_with({{.mesh = &inner_}}));
  const Light both =
      middle_of(drawn_with({{.mesh = &outer_, .opacity = 0.25, .color = red_}, {.mesh = &inner_}}));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(both[i], 0.25F * outer[i] + 0.75F * inner[i], 0.01F) << i;
  }
}

TEST_F(NestedBalls, AreIndependentOfTheOrderOfSurfaces) {
  const DrawnSurface outer{.mesh = &outer_, .opacity = 0.25, .color = red_};
  const DrawnSurface inner{.mesh = &inner_, .opacity = 0.5};
  const Picture picture = drawn_with({outer, inner});
  EXPECT_EQ(picture.pixels, drawn_with({inner, outer}).pixels);
  EXPECT_EQ(picture.pixels, drawn_with({inner, outer}, {.threads = 3}).pixels);
}

TEST_F(NestedBalls, ShowTheBackgroundWithoutSolidSurfaces) {
  const DrawOptions options{.background = Background::kTransparent};
  const Picture one = drawn_with({{.mesh = &outer_, .opacity = 0.5}}, options);
  EXPECT_NEAR(one.at(80, 60)[3], 255 * (1 - 0.5 * 0.5), 1);  // The front and the back of the ball.
  const Picture two =
      drawn_with({{.mesh = &outer_, .opacity = 0.5}, {.mesh = &inner_, .opacity = 0.5}}, options);
  EXPECT_NEAR(two.at(80, 60)[3], 255 * (1 - 1 / 16.0), 1);
  EXPECT_EQ(two.at(0, 0)[3], 0);
}

// ---- volumes

// Looks along +y at a volume of cubic samples around the origin, nearly in parallel.
DrawnVolume made_volume(int n, const std::function<float(int, int, int)>& value) {
  const double half = (n - 1) / 2.0;
  DrawnVolume volume{.counts = {std::size_t(n), std::size_t(n), std::size_t(n)},
                     .values = {},
                     .to_world = {},
                     .opacities = {{0, 0.05}},
                     .colors = {.low = 0, .high = 255},
                     .is_lit = false};
  volume.to_world.translation = {-half, -half, -half};
  for (int z = 0; z < n; ++z) {
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) volume.values.push_back(value(x, y, z));
    }
  }
  return volume;
}

Camera far_camera(int pixels, double pixels_a_sample) {
  const double distance = 1e5;
  return {.width = pixels,
          .height = pixels,
          .eye = {0, -distance, 0},
          .pixels_at_one = pixels_a_sample * distance,
          .distance = distance};
}

Picture drawn_volume(const DrawnVolume& volume, const Camera& camera,
                     std::span<const DrawnSurface> surfaces = {}, int threads = 1) {
  return drawn(surfaces, camera,
               {.background = Background::kTransparent, .volume = &volume, .threads = threads});
}

const Pixel& pixel_at(const Picture& picture, int x, int y) {
  return picture.pixels[static_cast<std::size_t>(y * picture.width + x)];
}

PositionedMesh wall_at(double y) {
  return {.positions = {{-99, y, -99}, {99, y, -99}, {0, y, 99}}, .triangles = {{0, 1, 2}}};
}

TEST(Volume, LetsAsMuchLightPassAsItsVoxels) {
  const DrawnVolume volume = made_volume(17, [](int, int, int) { return 128.0F; });
  const Picture picture = drawn_volume(volume, far_camera(9, 0.5));
  EXPECT_NEAR(pixel_at(picture, 4, 4)[3], 255 * (1 - std::pow(0.95, 16)), 1.01);
  EXPECT_NEAR(pixel_at(picture, 4, 4)[0], 128, 1.01) << "Its color does not depend on opacity.";
}

TEST(Volume, ShowsTheLargestValueOfEachLine) {
  std::mt19937 random(7);
  DrawnVolume volume =
      made_volume(8, [&](int, int, int) { return static_cast<float>(random() % 256); });
  volume.is_maximum = true;
  // Pixels are centered between four columns of samples.
  const Picture picture = drawn_volume(volume, far_camera(7, 1));
  for (int z = 0; z < 7; ++z) {
    for (int x = 0; x < 7; ++x) {
      float largest = 0;
      for (int y = 0; y < 8; ++y) {
        const float* const at = &volume.values[static_cast<std::size_t>((z * 8 + y) * 8 + x)];
        largest = std::max(largest, (at[0] + at[1] + at[64] + at[65]) / 4);
      }
      EXPECT_NEAR(pixel_at(picture, x, 6 - z)[0], largest, 1.01) << x << "," << z;
      EXPECT_EQ(pixel_at(picture, x, 6 - z)[3], 255);
    }
  }
}

TEST(Volume, EndsWhereTheSurfaceOfItsStepDoes) {
  const double radius = 12.3;
  const auto height = [&](int x, int y, int z) {
    return static_cast<float>(100 + 5 * (radius - std::hypot(x - 16, y - 16, z - 16)));
  };
  DrawnVolume volume = made_volume(33, height);
  volume.opacities = {{100, 0}, {100, 1}};
  const Camera camera = far_camera(80, 2);
  PositionedMesh surface = ball({0, 0, 0}, 60);
  for (Vec3& p : surface.positions) p = scaled(p, radius);
  const Picture of_volume = drawn_volume(volume, camera);
  const Picture of_surface = drawn(surface, camera, {.background = Background::kTransparent});
  for (int y = 1; y < 79; ++y) {
    for (int x = 1; x < 79; ++x) {
      // All of the surface's neighbors agree: no silhouette within a pixel.
      int seen = 0;
      for (const int dx : {-1, 0, 1}) {
        for (const int dy : {-1, 0, 1}) seen += pixel_at(of_surface, x + dx, y + dy)[3] > 127;
      }
      if (seen == 0) {
        EXPECT_LT(pixel_at(of_volume, x, y)[3], 20) << x << "," << y;
      }
      if (seen == 9) {
        EXPECT_GT(pixel_at(of_volume, x, y)[3], 235) << x << "," << y;
      }
    }
  }
}

TEST(Volume, IsCutBySurfacesInItsOrder) {
  DrawnVolume volume = made_volume(17, [](int, int, int) { return 255.0F; });
  volume.opacities = {{0, 0.2}};
  const Camera camera = far_camera(9, 0.5);
  const auto middle = [&](std::vector<DrawnSurface> surfaces) {
    return pixel_at(drawn_volume(volume, camera, surfaces), 4, 4);
  };
  const PositionedMesh before = wall_at(-30);
  const PositionedMesh within = wall_at(0);
  const PositionedMesh behind = wall_at(30);
  const Light black = {0, 0, 0};
  EXPECT_LT(middle({{.mesh = &before, .color = black}})[0], 60) << "It hides all of it.";
  const auto passing = [](double voxels) { return std::pow(0.8, voxels); };
  // White light in front of black, whose highlight is faint.
  EXPECT_NEAR(middle({{.mesh = &behind, .color = black}})[0], srgb_from(1 - passing(16)), 3);
  const double shine = linear_light(middle({{.mesh = &before, .color = black}})[0]);
  EXPECT_NEAR(middle({{.mesh = &within, .color = black}})[0],
              srgb_from(1 - passing(8) + passing(8) * shine), 2);
  // Half of a translucent layer between its halves.
  EXPECT_NEAR(middle({{.mesh = &within, .opacity = 0.5, .color = black}})[3],
              255 * (1 - 0.5 * passing(16)), 1.01);
  const DrawnSurface faint = {.mesh = &within, .opacity = 1e-4, .color = black};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(middle({faint})[i], middle({})[i], 1.01);
}

TEST(Volume, HasItsLargestValueBehindAllLayers) {
  DrawnVolume volume = made_volume(17, [](int, int y, int) { return y == 12 ? 255.0F : 50.0F; });
  volume.is_maximum = true;
  const PositionedMesh within = wall_at(0);  // In front of the largest value.
  const Camera camera = far_camera(9, 0.5);
  const auto middle = [&](double opacity) {
    const DrawnSurface surface = {.mesh = &within, .opacity = opacity, .color = Light{0, 0, 0}};
    return pixel_at(drawn_volume(volume, camera, std::array{surface}), 4, 4)[0];
  };
  EXPECT_NEAR(middle(1e-4), 255, 1.01);
  EXPECT_NEAR(middle(0.5), 192, 6) << "Half of white, and some of a highlight on black.";
  EXPECT_NEAR(middle(1), 50, 1.01) << "Rays end at solid surfaces.";
}

TEST(Volume, HasNothingWhereThereAreNoValues) {
  const float none = std::numeric_limits<float>::quiet_NaN();
  for (const bool is_maximum : {false, true}) {
    DrawnVolume volume = made_volume(20, [&](int x, int, int) { return x < 10 ? none : 200.0F; });
    volume.is_maximum = is_maximum;
    volume.is_lit = true;
    const Picture picture = drawn_volume(volume, far_camera(20, 1));
    EXPECT_EQ(pixel_at(picture, 3, 10)[3], 0);
    EXPECT_GT(pixel_at(picture, 16, 10)[3], 100);
  }
}

TEST(Volume, IsDrawnAlikeByAnyNumberOfThreads) {
  std::mt19937 random(11);
  DrawnVolume volume =
      made_volume(24, [&](int, int, int) { return static_cast<float>(random() % 256); });
  volume.is_lit = true;
  volume.to_world.columns = {Vec3{1, 0.2, 0}, Vec3{0, 0.8, 0.1}, Vec3{0.3, 0, 1.5}};
  volume.opacities = {{40, 0}, {90, 0.02}, {90, 0.3}, {200, 0}};
  const PositionedMesh surface = ball({0, 0, 0});
  const Camera camera = framing(surface.positions, 40, 20, 100, 80);
  const std::array surfaces = {DrawnSurface{.mesh = &surface, .opacity = 0.5}};
  EXPECT_EQ(drawn_volume(volume, camera, surfaces, 1).pixels,
            drawn_volume(volume, camera, surfaces, 5).pixels);
}

TEST(Picture, IsIndependentOfThreadCount) {
  const PositionedMesh mesh = joined(ball({0, 0, 0}, 40), ball({1, 1, 0}, 40));
  const Picture once = picture_of(mesh, 33, 21, {.threads = 1}, 333, 257);
  for (const int threads : {1, 2, 5}) {
    EXPECT_EQ(picture_of(mesh, 33, 21, {.threads = threads}, 333, 257).pixels, once.pixels);
  }
  const Picture wired = picture_of(mesh, 33, 21, {.wireframe = true, .threads = 1}, 333, 257);
  EXPECT_EQ(picture_of(mesh, 33, 21, {.wireframe = true, .threads = 3}, 333, 257).pixels,
            wired.pixels);
}

TEST(Picture, ShowsTheBackgroundForAnEmptyMesh) {
  const Picture dark = picture_of({}, 30, 15);
  const Picture light = picture_of({}, 30, 15, {.background = Background::kLight});
  EXPECT_LT(brightness(dark.at(80, 60)), 200);
  EXPECT_GT(brightness(dark.at(80, 60)), brightness(dark.at(0, 0)));
  EXPECT_GT(brightness(light.at(80, 60)), 700);
  EXPECT_EQ(dark.at(80, 60)[3], 255);
}

TEST(Picture, SupportsOnePixel) {
  const Picture picture = picture_of(ball({0, 0, 0}), 0, 0, {}, 1, 1);
  ASSERT_EQ(picture.pixels.size(), 1U);
}

TEST(PngFile, WritesDeterministicFilesOfTheRequestedSize) {
  const Picture picture = picture_of(ball({0, 0, 0}), 0, 0, {}, 48, 32);
  const std::string bytes = png_file(picture);
  EXPECT_EQ(bytes.substr(0, 8), "\x89PNG\r\n\x1a\n");
  EXPECT_EQ(bytes.substr(16, 8), std::string("\0\0\0\x30\0\0\0\x20", 8));
  EXPECT_EQ(png_file(picture), bytes);
}

// Counts the dark pixels in a part of a picture.
int dark_pixels(const Picture& picture, int left, int top, int right, int bottom) {
  int count = 0;
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x)
      count += picture.at(x, y)[3] > 200 && brightness(picture.at(x, y)) < 400 ? 1 : 0;
  }
  return count;
}

Picture empty(int width, int height) {
  return {.width = width,
          .height = height,
          .pixels = std::vector<Pixel>(static_cast<std::size_t>(width * height),
                                       Pixel{255, 255, 255, 255})};
}

TEST(ScaleBar, HasARoundLengthThatFitsThePicture) {
  for (const double radius : {0.001, 3.0, 700.0}) {
    PositionedMesh mesh = ball({0, 0, 0});
    for (auto& place : mesh.positions) {
      for (double& part : place) part *= radius;
    }
    const Camera camera = framing(mesh.positions, 0, 0, 1280, 720);
    const ScaleLength length = scale_length(camera);
    EXPECT_GT(length.pixels, 40) << radius;
    EXPECT_LE(length.pixels, 110.001) << radius;
    // The same length as that distance between two places in the middle of the picture.
    EXPECT_NEAR(length.world * camera.pixels_at_one / -camera.seen({0, 0, 0})[2], length.pixels,
                1e-6)
        << radius;
    const double digit = length.world / std::pow(10, std::floor(std::log10(length.world) + 1e-9));
    EXPECT_NEAR(std::min({std::abs(digit - 1), std::abs(digit - 2), std::abs(digit - 5)}), 0, 1e-9)
        << radius;
  }
}

TEST(ScaleBar, HasAStrokeAtEachEnd) {
  const Camera camera = framing(ball({0, 0, 0}).positions, 0, 0, 1280, 720);
  const int length = static_cast<int>(scale_length(camera).pixels);
  Picture picture = empty(1280, 720);
  draw_scale_bar(picture, camera, "mm", Background::kLight);
  const int left = 1280 - 16 - length;
  EXPECT_GT(dark_pixels(picture, left, 698, 1266, 703), length - 4);
  for (const int end : {left, 1280 - 16}) {
    EXPECT_GT(dark_pixels(picture, end - 2, 695, end + 3, 699), 2) << end;
    EXPECT_GT(dark_pixels(picture, end - 2, 701, end + 3, 706), 2) << end;
  }
  EXPECT_GT(dark_pixels(picture, left, 676, 1264, 692), 30);  // The text of the length.
  EXPECT_EQ(dark_pixels(picture, 0, 0, left - 60, 720), 0);
}

TEST(ScaleBar, KeepsLongTextsWithinTheMargin) {
  const Camera camera = framing(ball({0, 0, 0}).positions, 0, 0, 1280, 720);
  Picture picture = empty(1280, 720);
  draw_scale_bar(picture, camera, "arbitrary length units", Background::kLight);
  EXPECT_GT(dark_pixels(picture, 1280 - 200, 676, 1264, 692), 30);
  EXPECT_EQ(dark_pixels(picture, 1280 - 14, 0, 1280, 692), 0);
}

TEST(Legend, RunsFromTheFirstColorToTheLast) {
  Picture picture = empty(1280, 720);
  draw_legend(picture,
              {.scale = {.map = ColorMap::kViridis, .low = 300, .high = 1250},
               .name = "temperature",
               .unit = "K"},
              Background::kLight);
  const Pixel first = picture.at(17, 682);
  const Pixel last = picture.at(214, 682);
  EXPECT_NEAR(first[2], color_at(ColorMap::kViridis, 0)[2], 8);
  EXPECT_NEAR(last[0], color_at(ColorMap::kViridis, 1)[0], 8);
  EXPECT_GT(dark_pixels(picture, 16, 692, 60, 706), 20);    // 300
  EXPECT_GT(dark_pixels(picture, 150, 692, 220, 706), 20);  // 1250 K
  EXPECT_GT(dark_pixels(picture, 16, 658, 150, 674), 60);   // temperature
}

constexpr Canvas::TextStyle kBlack = {.size = 24, .color = {0, 0, 0}, .rim = Rgb{255, 255, 255}};

TEST(Canvas, DrawsTextOfAnyScriptAsWideAsItSays) {
  for (const std::string text : {"A", "~", "5 \u00b5m\u00b3", "\u03b8", "\u0442\u0435\u043c"}) {
    Picture picture = empty(140, 60);
    double width = 0;
    {
      Canvas canvas(picture);
      width = canvas.text_width(text, kBlack);
      canvas.text({10, 40}, text, kBlack);
      canvas.text({-500, 900}, "far beyond", kBlack);
    }
    EXPECT_GE(dark_pixels(picture, 0, 0, 140, 60), 4) << text;
    EXPECT_EQ(dark_pixels(picture, 0, 0, 8, 60), 0) << text;
    EXPECT_EQ(dark_pixels(picture, static_cast<int>(10 + width) + 3, 0, 140, 60), 0) << text;
  }
}

TEST(Canvas, IsLegibleOnATransparentBackground) {
  Picture picture = {
      .width = 40, .height = 40, .pixels = std::vector<Pixel>(1600, Pixel{0, 0, 0, 0})};
  Canvas(picture).text({10, 30}, "A", kBlack);
  EXPECT_GT(dark_pixels(picture, 0, 0, 40, 40), 10);
  EXPECT_EQ(picture.at(1, 1)[3], 0);
}

TEST(Drawing, HasTheFormatOfItsSuffix) {
  for (const auto& [suffix, start] :
       {std::pair(".svg", "<?xml"), {".pdf", "%PDF"}, {".png", "\x89PNG"}}) {
    const std::string file = drawing(suffix, 100, 50, [](Canvas& canvas) {
      canvas.text({10, 30}, "A & B", {});
    });
    EXPECT_TRUE(file.starts_with(start)) << suffix;
    EXPECT_GT(file.size(), 400U) << suffix;
  }
}

}  // namespace
}  // namespace multitetra
