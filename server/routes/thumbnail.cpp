// Thumbnails of datasets: a small picture of the suggested surface, for lists.
#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>
#include <utility>

#include "common/base/lru_map.hpp"
#include "common/base/number_text.hpp"
#include "common/dataset/series_member.hpp"
#include "common/image/png_file.hpp"
#include "common/image/srgb.hpp"
#include "common/picture/rasterizer.hpp"
#include "common/request/request_key.hpp"
#include "server/http/conditions.hpp"
#include "server/routes/detail/thumbnail_query.hpp"
#include "server/routes/resource.hpp"
#include "server/tilesets/tileset.hpp"

namespace multitetra {
namespace {

// The version of the output. Increase it when equal requests give different bytes.
constexpr std::string_view kThumbnailForm = "thumbnail 1 ";
constexpr int kWidth = 128;
constexpr int kHeight = 96;
constexpr std::uint64_t kMaxTriangles = 2'000'000;

// Returns a request for a preview of the whole surface, twice as fine as the root of 3D Tiles.
IsosurfaceRequest preview(const DatasetInfo& info, double isovalue) {
  const Tileset tileset(info, {.isovalue = isovalue});
  IsosurfaceRequest request = tileset.request(tileset.root());
  std::int32_t& spacing = request.cell->finest_spacing;
  if (spacing > 1) spacing /= 2;
  request.error = std::min(request.error, spacing / 4.0);
  request.simplify = false;  // Facets would be visible.
  request.topology_tolerance /= 2;
  return request;
}

std::string thumbnail_of(const Surface& surface, const DatasetInfo& info, const Vec3& up) {
  const PositionedMesh mesh = positioned(surface.mesh, grid_to_world(info));
  DrawnSurface drawn_surface{.mesh = &mesh};
  const auto color = info.member ? display_color(*info.member) : std::nullopt;
  if (color) drawn_surface.color = linear_light(unpacked(*color));
  const Camera camera =
      framing(mesh.positions, kDefaultAzimuth, kDefaultElevation, kWidth, kHeight, up);
  return png_file(
      drawn({&drawn_surface, 1}, camera, {.background = Background::kTransparent, .threads = 1}));
}

class ThumbnailRoute {
 public:
  // Returns a PNG of 128 x 96 pixels with a transparent background. The surface is a preview. Makes
  // nothing for HEAD, nor if the client's copy is current.
  [[nodiscard]] asio::awaitable<HttpResponse> answer(ResourceRequest request) {
    RequestContext& context = request.context;
    const auto query = parse_thumbnail_query(request.target.query);
    if (!query) co_return context.refused(query.error());
    const auto info = context.service_client->client_access().describe(request.path[0]);
    if (!info) co_return context.refused(info.error());
    const auto& suggested = info->suggested_isovalues;
    const double isovalue = query->isovalue.value_or(suggested.empty() ? info->min : suggested[0]);
    SurfacesRequest surface{.dataset = info->name,
                            .requests = {preview(*info, isovalue)},
                            .max_triangles = kMaxTriangles};
    context.record->set_surface(isovalue, surface.requests[0].error, name(ErrorUnit::kVoxel));
    const std::string key = std::string(kThumbnailForm) + key_of(*info) + ' ' +
                            shortest_text(isovalue) + ' ' + query->up;
    const std::string tag = info->content_id != 0 ? tag_of(key) : "";
    HttpResponse response;
    add_field(response, "Content-Type", "image/png");
    add_field(response, "Cache-Control", "no-cache");
    if (const SharedBytes* const kept = tag.empty() ? nullptr : kept_.find(key)) {
      response.body = body_of(*kept);
    } else if (!needs_body(request.http, tag)) {
      response.is_length_known = false;
    } else {
      if (context.watch) context.watch();
      std::function<Result<SharedBytes>(std::vector<Surface>, const std::stop_token&)> draw =
          [info = *info, up = *up_axis_from(query->up)](const std::vector<Surface>& surfaces,
                                                        const std::stop_token&) {
            return std::make_shared<const std::string>(thumbnail_of(surfaces.front(), info, up));
          };
      const auto picture = co_await context.service_client->made_from_surfaces<SharedBytes>(
          std::move(surface), "thumbnail", std::move(draw));
      if (!picture) co_return context.refused(picture.error());
      if (!tag.empty()) kept_.add(key, *picture, (*picture)->size() + key.size());
      response.body = body_of(*picture);
    }
    if (!tag.empty()) apply_conditions(response, request.http, tag);
    co_return response;
  }

 private:
  static constexpr std::size_t kMaxCachedBytes = std::size_t{8} << 20;

  LruMap<std::string, SharedBytes> kept_{kMaxCachedBytes};
};

}  // namespace

Resource thumbnail_resource(const ResourceContext&) {
  const auto route = std::make_shared<ThumbnailRoute>();
  return {.name = "thumbnail",
          .path = "/v1/datasets/{name}/thumbnail.png",
          .answer = [route](ResourceRequest request) { return route->answer(request); }};
}

}  // namespace multitetra
