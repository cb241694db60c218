#include "common/picture/rasterizer.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "common/base/on_threads.hpp"
#include "common/base/vec3.hpp"
#include "common/picture/detail/layers.hpp"
#include "common/picture/detail/volume_rays.hpp"

namespace multitetra {
namespace {

constexpr int kSubpixels = 256;  // Corners are rounded to 1/256 pixel.
constexpr int kBandRows = 32;    // Each thread draws bands of this many rows.

// Sample positions in subpixels from the upper left corner of a pixel. No two share a row or
// column, so that edges in every direction are smooth.
constexpr std::array<std::array<int, 2>, kSamples> kSamplePlaces = {
    {{144, 80}, {112, 176}, {208, 144}, {80, 48}, {48, 208}, {16, 112}, {176, 240}, {240, 16}}};

// The largest distance of a corner from the picture, in subpixels.
constexpr double kMaxPixelCoordinate = 1 << 26;

// The width of a wire on each side of an edge; both triangles draw their half.
constexpr double kHalfWire = 0.5 * kSubpixels;
// Wires are drawn in full on triangles of at least this height, and fade on smaller ones.
constexpr double kWiredHeight = 6 * kSubpixels;
// The fraction of the surface's light that remains under a wire.
constexpr float kWireLight = 0.2F;

// A projected corner.
struct Corner {
  std::int32_t x = 0;  // Subpixels from the left.
  std::int32_t y = 0;  // From above.
  // The reciprocal of the depth, which is linear in the picture; 0: not visible.
  double nearness = 0;
};

// Returns twice the area of the triangle (a, b, place); positive when the place is to the right of
// a -> b, as rows count downwards.
std::int64_t side(const Corner& a, const Corner& b, std::int64_t x, std::int64_t y) {
  return (std::int64_t{b.x} - a.x) * (y - a.y) - (std::int64_t{b.y} - a.y) * (x - a.x);
}

// A sample exactly on an edge belongs to the triangle whose left or upper edge it is.
std::int64_t owed(const Corner& a, const Corner& b) {
  const bool is_owner = b.y < a.y || (b.y == a.y && b.x > a.x);
  return is_owner ? 0 : 1;
}

std::vector<Corner> corners_of(const PositionedMesh& mesh, const Camera& camera) {
  std::vector<Corner> corners;
  corners.reserve(mesh.positions.size());
  for (const auto& position : mesh.positions) {
    const Vec3 seen = camera.seen(position);
    const double nearness = -1 / seen[2];
    const double scale = camera.pixels_at_one * nearness;
    const double x = kSubpixels * (camera.width / 2.0 + scale * seen[0]);
    const double y = kSubpixels * (camera.height / 2.0 - scale * seen[1]);
    const bool is_seen =
        seen[2] < 0 && std::abs(x) < kMaxPixelCoordinate && std::abs(y) < kMaxPixelCoordinate;
    corners.push_back(is_seen ? Corner{.x = static_cast<std::int32_t>(std::lround(x)),
                                       .y = static_cast<std::int32_t>(std::lround(y)),
                                       .nearness = nearness}
                              : Corner{});
  }
  return corners;
}

// Returns vertex normals: area-weighted means of the normals of adjacent triangles.
std::vector<UnitVector> averaged_normals(const PositionedMesh& mesh) {
  std::vector<Vec3> sums(mesh.positions.size(), Vec3{0, 0, 0});
  for (const TriangleIndices& triangle : mesh.triangles) {
    const Vec3 a = mesh.positions[triangle[0]];
    const Vec3 b = mesh.positions[triangle[1]];
    const Vec3 c = mesh.positions[triangle[2]];
    const Vec3 across = cross(difference(b, a), difference(c, a));
    for (const std::uint32_t vertex : triangle) sums[vertex] = sum(sums[vertex], across);
  }
  std::vector<UnitVector> normals;
  normals.reserve(sums.size());
  for (const Vec3& sum : sums) {
    const Vec3 n = normalized(sum);
    normals.push_back(
        {static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])});
  }
  return normals;
}

std::vector<Light> lights_of(const PositionedMesh& mesh) {
  std::vector<Light> lights;
  lights.reserve(mesh.colors.size());
  for (const Rgb& color : mesh.colors) lights.push_back(linear_light(color));
  return lights;
}

// A surface with the data shared by all bands.
struct SeenSurface {
  const PositionedMesh& mesh;
  float opacity = 1;
  std::optional<Light> color;  // nullopt: the default color.
  // Computed if the mesh needs normals and has none.
  std::vector<UnitVector> own_normals;
  // The colors of the vertices; empty: none.
  std::vector<Light> colors;
  std::vector<Corner> corners;
  // Triangles that may be visible in each band, in order.
  std::vector<std::vector<std::uint32_t>> bands;

  [[nodiscard]] const std::vector<UnitVector>& normals() const {
    return mesh.normals.empty() ? own_normals : mesh.normals;
  }
};

struct Scene {
  const Camera& camera;
  const DrawOptions& options;
  std::vector<SeenSurface> surfaces;
  std::optional<VolumeRays> volume;
};

std::vector<std::vector<std::uint32_t>> bands_of(const PositionedMesh& mesh, const Camera& camera,
                                                 const std::vector<Corner>& corners) {
  const int count = (camera.height + kBandRows - 1) / kBandRows;
  std::vector<std::vector<std::uint32_t>> bands(static_cast<std::size_t>(count));
  const auto band_at = [&](std::int32_t y) {
    return static_cast<std::size_t>(std::clamp(y / (kSubpixels * kBandRows), 0, count - 1));
  };
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    if (corners[a].nearness == 0 || corners[b].nearness == 0 || corners[c].nearness == 0) continue;
    const auto [low, high] = std::minmax({corners[a].y, corners[b].y, corners[c].y});
    for (std::size_t band = band_at(low); band <= band_at(high); ++band) bands[band].push_back(t);
  }
  return bands;
}

// A band of rows with all its samples.
class Band {
 public:
  Band(const Scene& scene, std::size_t number)
      : scene_(scene),
        first_row_(static_cast<int>(number) * kBandRows),
        rows_(std::min(kBandRows, scene.camera.height - first_row_)),
        samples_(static_cast<std::size_t>(rows_) * static_cast<std::size_t>(scene.camera.width) *
                 kSamples) {
    const auto is_solid = [](const SeenSurface& surface) { return surface.opacity >= 1; };
    draw_all(number, is_solid);
    draw_all(number, [&](const SeenSurface& surface) { return !is_solid(surface); });
    const auto volume_at = [&, ray = VolumeRay()](std::uint32_t pixel) mutable -> VolumePart {
      const auto [row, x] = std::div(static_cast<int>(pixel), scene.camera.width);
      scene.volume->trace(x, first_row_ + row, ray);
      return {.between = [&ray](double near, double far) { return ray.between(near, far); },
              .has_order = !scene.options.volume->is_maximum};
    };
    using VolumeAt = std::function<VolumePart(std::uint32_t)>;
    mixes_ = mixes_of(std::exchange(fragments_, {}), samples_,
                      scene.volume ? VolumeAt(volume_at) : nullptr);
  }

  void write(Picture& picture) const {
    for (int row = 0; row < rows_; ++row) {
      for (int x = 0; x < picture.width; ++x) {
        const int y = first_row_ + row;
        picture.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) +
                       static_cast<std::size_t>(x)] = pixel(x, y);
      }
    }
  }

 private:
  template <typename Choice>
  void draw_all(std::size_t number, const Choice& is_chosen) {
    for (const SeenSurface& surface : scene_.surfaces) {
      if (!is_chosen(surface)) continue;
      surface_ = &surface;
      for (const std::uint32_t triangle : surface.bands[number]) {
        draw(surface.mesh.triangles[triangle]);
      }
    }
  }

  [[nodiscard]] std::size_t first_sample(int x, int y) const {
    return (static_cast<std::size_t>(y - first_row_) *
                static_cast<std::size_t>(scene_.camera.width) +
            static_cast<std::size_t>(x)) *
           kSamples;
  }

  // The constants of a triangle.
  struct Drawn {
    TriangleIndices indices;  // In the order that makes `area` positive.
    std::int64_t area = 0;    // Twice the area, in square subpixels.
    bool is_inside = false;
    // The triangle's normal, for flat shading.
    Vec3 normal = {0, 0, 0};
    // The largest side() of each edge within its wire.
    std::array<double, 3> wire = {-1, -1, -1};
    float wire_light = 1;
  };

  [[nodiscard]] const Corner& corner(const Drawn& t, std::size_t i) const {
    return surface_->corners[t.indices[i % 3]];
  }

  void draw(const TriangleIndices& indices) {
    Drawn t{.indices = indices};
    t.area = side(corner(t, 0), corner(t, 1), corner(t, 2).x, corner(t, 2).y);
    if (t.area == 0) return;
    const auto& points = surface_->mesh.positions;
    const Vec3 a = points[indices[0]];
    t.normal = cross(difference(points[indices[1]], a), difference(points[indices[2]], a));
    // Triangles are counterclockwise when seen from outside; rows count downwards.
    t.is_inside = t.area > 0;
    if (t.area < 0) {
      std::swap(t.indices[1], t.indices[2]);
      t.area = -t.area;
    }
    if (scene_.options.wireframe) add_wires(t);
    const auto [left, right] = std::minmax({corner(t, 0).x, corner(t, 1).x, corner(t, 2).x});
    const auto [above, below] = std::minmax({corner(t, 0).y, corner(t, 1).y, corner(t, 2).y});
    const int last_row = std::min(below / kSubpixels, first_row_ + rows_ - 1);
    const int last_column = std::min(right / kSubpixels, scene_.camera.width - 1);
    for (int y = std::max(above / kSubpixels, first_row_); y <= last_row; ++y) {
      for (int x = std::max(left / kSubpixels, 0); x <= last_column; ++x) draw_pixel(t, x, y);
    }
  }

  // side() of an edge is its length times the distance from it.
  void add_wires(Drawn& t) const {
    double longest = 0;
    for (std::size_t i = 0; i < 3; ++i) {  // Opposite to corner i.
      const Corner& from = corner(t, i + 1);
      const Corner& to = corner(t, i + 2);
      const double length = std::hypot(to.x - from.x, to.y - from.y);
      t.wire[i] = kHalfWire * length;
      longest = std::max(longest, length);
    }
    const double height = static_cast<double>(t.area) / longest;
    const auto strength = static_cast<float>(std::min(1.0, height / kWiredHeight));
    t.wire_light = 1 - strength * (1 - kWireLight);
  }

  // Draws the samples of a pixel that the triangle covers and for which it is the nearest so far.
  void draw_pixel(const Drawn& t, int x, int y) {
    const Corner& a = corner(t, 0);
    const Corner& b = corner(t, 1);
    const Corner& c = corner(t, 2);
    Sample* const samples = &samples_[first_sample(x, y)];
    const bool is_solid = surface_->opacity >= 1;
    Fragment fragment{.pixel = static_cast<std::uint32_t>(first_sample(x, y) / kSamples),
                      .opacity = surface_->opacity};
    struct Covered {
      std::size_t sample = 0;
      bool is_wire = false;
    };
    std::array<Covered, kSamples> covered{};
    std::size_t count = 0;
    // The centroid of the covered samples, as weights of the corners.
    std::array<double, 3> middle = {0, 0, 0};
    for (std::size_t i = 0; i < kSamples; ++i) {
      const std::int64_t sx = std::int64_t{x} * kSubpixels + kSamplePlaces[i][0];
      const std::int64_t sy = std::int64_t{y} * kSubpixels + kSamplePlaces[i][1];
      const std::int64_t of_a = side(b, c, sx, sy);
      const std::int64_t of_b = side(c, a, sx, sy);
      const std::int64_t of_c = t.area - of_a - of_b;
      if (of_a < owed(b, c) || of_b < owed(c, a) || of_c < owed(a, b)) continue;
      const std::array<double, 3> sides = {static_cast<double>(of_a), static_cast<double>(of_b),
                                           static_cast<double>(of_c)};
      const auto area = static_cast<double>(t.area);
      const std::array<double, 3> weights = {sides[0] / area, sides[1] / area, sides[2] / area};
      const double nearness =
          weights[0] * a.nearness + weights[1] * b.nearness + weights[2] * c.nearness;
      if (nearness <= samples[i].nearness) continue;
      if (is_solid) samples[i].nearness = nearness;
      fragment.nearness[i] = static_cast<float>(nearness);
      covered[count++] = {i,
                          sides[0] <= t.wire[0] || sides[1] <= t.wire[1] || sides[2] <= t.wire[2]};
      for (std::size_t j = 0; j < 3; ++j) middle[j] += weights[j];
    }
    if (count == 0) return;
    const Light light = light_at(t, middle);
    const Light wire = {t.wire_light * light[0], t.wire_light * light[1], t.wire_light * light[2]};
    for (std::size_t i = 0; i < count; ++i) {
      const auto [sample, is_wire] = covered[i];
      if (is_solid) samples[sample].light = is_wire ? wire : light;
      fragment.covered |= static_cast<std::uint8_t>(1U << sample);
      if (is_wire) fragment.wires |= static_cast<std::uint8_t>(1U << sample);
    }
    if (is_solid) return;
    fragment.light = light;
    fragment.wire = wire;
    fragments_.push_back(fragment);
  }

  // `weights`: of the corners in the picture, with any sum.
  [[nodiscard]] Light light_at(const Drawn& t, std::array<double, 3> weights) const {
    const bool is_flat = scene_.options.shading == Shading::kFlat;
    Vec3 place = {0, 0, 0};
    Vec3 normal = is_flat ? t.normal : Vec3{0, 0, 0};
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      weights[i] *= corner(t, i).nearness;  // Converts to weights in space.
      sum += weights[i];
    }
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        place[axis] += weights[i] / sum * surface_->mesh.positions[t.indices[i]][axis];
        if (!is_flat) normal[axis] += weights[i] * surface_->normals()[t.indices[i]][axis];
      }
    }
    std::optional<Light> color = surface_->color;
    if (!surface_->colors.empty()) {
      color.emplace(Light{0, 0, 0});
      for (std::size_t i = 0; i < 3; ++i) {
        const Light& corner_color = surface_->colors[t.indices[i]];
        const auto weight = static_cast<float>(weights[i] / sum);
        for (std::size_t j = 0; j < 3; ++j) (*color)[j] += weight * corner_color[j];
      }
    }
    const Camera& camera = scene_.camera;
    const double sign = t.is_inside ? -1 : 1;
    const Vec3 seen = camera.seen(place);
    return shaded(normalized({sign * dot(normal, camera.right), sign * dot(normal, camera.up),
                              sign * dot(normal, camera.back)}),
                  normalized({-seen[0], -seen[1], -seen[2]}),
                  {camera.right[2], camera.up[2], camera.back[2]}, t.is_inside, color);
  }

  [[nodiscard]] Pixel pixel(int x, int y) const {
    const Camera& camera = scene_.camera;
    const bool has_background = scene_.options.background != Background::kTransparent;
    const Light behind = background_at(scene_.options.background, (2.0 * x + 1) / camera.width - 1,
                                       (2.0 * y + 1) / camera.height - 1);
    const std::size_t first = first_sample(x, y);
    const std::span<const Mix> mixes(mixes_);
    return pixel_of(std::span(samples_).subspan(first).first<kSamples>(),
                    mixes.empty() ? mixes : mixes.subspan(first, kSamples), behind, has_background);
  }

  const Scene& scene_;
  int first_row_;
  int rows_;
  std::vector<Sample> samples_;
  std::vector<Fragment> fragments_;       // In drawing order.
  std::vector<Mix> mixes_;                // Empty without translucent fragments.
  const SeenSurface* surface_ = nullptr;  // The surface being drawn.
};

}  // namespace

Picture drawn(const PositionedMesh& mesh, const Camera& camera, const DrawOptions& options) {
  return drawn(std::array{DrawnSurface{.mesh = &mesh}}, camera, options);
}

Picture drawn(std::span<const DrawnSurface> surfaces, const Camera& camera,
              const DrawOptions& options) {
  assert(camera.width > 0 && camera.width <= kMaxPictureSide);
  assert(camera.height > 0 && camera.height <= kMaxPictureSide);
  Scene scene{.camera = camera, .options = options, .surfaces = {}, .volume = {}};
  if (options.volume != nullptr) scene.volume.emplace(*options.volume, camera);
  for (const DrawnSurface& surface : surfaces) {
    assert(surface.opacity > 0 && surface.opacity <= 1);
    const PositionedMesh& mesh = *surface.mesh;
    const bool needs_own = mesh.normals.empty() && options.shading == Shading::kSmooth;
    SeenSurface seen{.mesh = mesh,
                     .opacity = static_cast<float>(surface.opacity),
                     .color = surface.color,
                     .own_normals = needs_own ? averaged_normals(mesh) : std::vector<UnitVector>(),
                     .colors = lights_of(mesh),
                     .corners = corners_of(mesh, camera),
                     .bands = {}};
    seen.bands = bands_of(mesh, camera, seen.corners);
    scene.surfaces.push_back(std::move(seen));
  }
  const auto bands = static_cast<std::size_t>((camera.height + kBandRows - 1) / kBandRows);
  Picture picture{.width = camera.width, .height = camera.height};
  picture.pixels.resize(static_cast<std::size_t>(camera.width) *
                        static_cast<std::size_t>(camera.height));
  const std::size_t threads = options.threads > 0
                                  ? static_cast<std::size_t>(options.threads)
                                  : std::max(1U, std::thread::hardware_concurrency());
  on_threads(threads, bands, [&](std::size_t band) { Band(scene, band).write(picture); });
  return picture;
}

}  // namespace multitetra
