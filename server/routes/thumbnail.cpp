#include "server/routes/thumbnail.hpp"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "common/base/number_text.hpp"
#include "common/base/parse_number.hpp"
#include "common/dataset/series_member.hpp"
#include "common/image/png_file.hpp"
#include "common/image/srgb.hpp"
#include "common/picture/rasterizer.hpp"
#include "common/request/request_key.hpp"
#include "server/http/conditions.hpp"
#include "server/routes/detail/query_parsers.hpp"
#include "server/service/run_on_workers.hpp"
#include "server/tilesets/tileset.hpp"

namespace multitetra {
namespace {

// The version of the output. Increase it when equal requests give different bytes.
constexpr std::string_view kThumbnailForm = "thumbnail 1 ";
constexpr int kWidth = 128;
constexpr int kHeight = 96;
constexpr std::uint64_t kMaxTriangles = 2'000'000;

struct ThumbnailQuery {
  std::optional<double> isovalue;
  std::string up = "z";
};

FieldError set_isovalue(std::string_view text, ThumbnailQuery& query) {
  query.isovalue = parse_finite(text);
  return query.isovalue ? std::nullopt : FieldError("give a finite number");
}

FieldError set_up(std::string_view text, ThumbnailQuery& query) {
  query.up = text;
  return up_axis_from(text) ? std::nullopt : FieldError("give x, -x, y, -y, z or -z");
}

Result<ThumbnailQuery> parse_thumbnail_query(const Target& target) {
  static const Setters<ThumbnailQuery> kSetters = {{"isovalue", {.set = set_isovalue}},
                                                   {"up", {.set = set_up}}};
  return parse_query<ThumbnailQuery>(target.query, kSetters);
}

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

}  // namespace

asio::awaitable<Answer> ThumbnailRoute::answer(const std::string& dataset, const Target& target,
                                               const HttpRequest& request,
                                               RequestContext& context) {
  const auto query = parse_thumbnail_query(target);
  if (!query) co_return context.refused(query.error());
  const auto info = context.caller->permit().describe(dataset);
  if (!info) co_return context.refused(info.error());
  const auto& suggested = info->suggested_isovalues;
  const double isovalue = query->isovalue.value_or(suggested.empty() ? info->min : suggested[0]);
  SurfaceRequest surface{.dataset = dataset,
                         .request = preview(*info, isovalue),
                         .max_triangles = kMaxTriangles};
  context.record->set_surface(isovalue, surface.request.error, name(ErrorUnit::kVoxel));
  const std::string key =
      std::string(kThumbnailForm) + key_of(*info) + ' ' + shortest_text(isovalue) + ' ' + query->up;
  const bool is_known = info->content_id != 0;
  const std::string tag = is_known ? tag_of(key) : "";
  Answer answer;
  add_field(answer, "Content-Type", "image/png");
  add_field(answer, "Cache-Control", "no-cache");
  if (const SharedBytes* const kept = is_known ? kept_.find(key) : nullptr) {
    answer.body = body_of(*kept);
  } else if (request.method() == http::verb::head ||
             (is_known && matches_tag(field(request, http::field::if_none_match), tag))) {
    answer.is_length_known = false;
  } else {
    if (context.watch) context.watch();
    auto made = co_await context.caller->surface(std::move(surface));
    if (!made) co_return context.refused(made.error());
    const ByteReservations::Reservation memory = std::move(made->memory);
    std::function<Result<SharedBytes>()> draw =
        [surface = std::make_shared<const Surface>(*std::move(made)), info = *info,
         up = *up_axis_from(query->up)]() -> Result<SharedBytes> {
      return std::make_shared<const std::string>(thumbnail_of(*surface, info, up));
    };
    const auto picture = co_await run_on_workers<SharedBytes>(
        drawing_, context.client->share(), "thumbnail", /*is_long=*/false, context.stop.get_token(),
        std::move(draw));
    if (!picture) co_return context.refused(picture.error());
    if (is_known) kept_.add(key, *picture, (*picture)->size() + key.size());
    answer.body = body_of(*picture);
  }
  if (is_known) apply_conditions(answer, request, tag);
  co_return answer;
}

}  // namespace multitetra
