// The samples: slices as pictures or numbers, and the field's value at given places.
#include <cmath>
#include <cstring>
#include <memory>
#include <utility>

#include "common/base/json.hpp"
#include "common/base/number_text.hpp"
#include "common/image/png_file.hpp"
#include "common/json/json_report.hpp"
#include "common/request/request_key.hpp"
#include "server/http/conditions.hpp"
#include "server/routes/detail/slice_query.hpp"
#include "server/routes/resource.hpp"

namespace multitetra {
namespace {

// The version of the output. Increase it when equal queries give different bytes.
constexpr std::string_view kSliceForm = "1";

std::string text_of(const Vec3& v) {
  return shortest_text(v[0]) + ',' + shortest_text(v[1]) + ',' + shortest_text(v[2]);
}

std::string rgb_text(const Rgb& color) {
  return std::to_string(color[0]) + ',' + std::to_string(color[1]) + ',' +
         std::to_string(color[2]) + ' ';
}

// Returns a key that identifies the output bytes.
std::string key_of(const DatasetInfo& info, const SliceRequest& slice, const SliceQuery& query,
                   const ColorScale& scale) {
  const std::string plane = serialize(ClientMessage(Slice{.dataset = info.name, .slice = slice}));
  if (query.format == SliceFormat::kRaw)
    return std::string(kSliceForm) + " raw " + key_of(info) + plane;
  return std::string(kSliceForm) + " png " + std::string(name(scale.map)) + ' ' +
         shortest_text(scale.low) + ' ' + shortest_text(scale.high) + ' ' +
         (scale.is_logarithmic ? "log " : "") +
         (query.no_value_color ? rgb_text(*query.no_value_color) : "") + key_of(info) + plane;
}

// The colors of values and of void samples.
struct PictureColors {
  ColorScale scale;
  // The scale has a color for void; otherwise it is transparent.
  bool has_no_value = false;
};

std::string picture_of(const SliceReply& slice, const PictureColors& colors) {
  Picture picture{.width = static_cast<int>(slice.width), .height = static_cast<int>(slice.height)};
  picture.pixels.resize(slice.values->size() / sizeof(float));
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    float value = 0;
    std::memcpy(&value, slice.values->data() + i * sizeof value, sizeof value);
    if (std::isnan(value) && !colors.has_no_value) continue;
    const Rgb color = colors.scale(static_cast<double>(value));
    picture.pixels[i] = {color[0], color[1], color[2], 255};
  }
  return png_file(picture, PngCompression::kQuick);
}

void add_plane(HttpResponse& response, const SliceRequest& plane) {
  add_field(response, "Multitetra-Width", std::to_string(plane.width));
  add_field(response, "Multitetra-Height", std::to_string(plane.height));
  add_field(response, "Multitetra-Origin", text_of(plane.origin));
  add_field(response, "Multitetra-Right", text_of(plane.right));
  add_field(response, "Multitetra-Down", text_of(plane.down));
}

Json json_of(const ProbedPlace& place) {
  Json json = {
      {"world", place.world}, {"index", place.index}, {"value", nullptr}, {"gradient", nullptr}};
  if (place.value) json["value"] = *place.value;
  if (place.gradient) json["gradient"] = *place.gradient;
  return json;
}

asio::awaitable<HttpResponse> slice_answer(ResourceRequest request) {
  RequestContext& context = request.context;
  const std::string& dataset = request.path[0];
  const auto allowed = context.service_client->client_access().check_samples();
  if (!allowed) co_return context.refused(allowed.error());
  const auto query = parse_slice_query(request.target.query);
  if (!query) co_return context.refused(query.error());
  const auto info = context.service_client->client_access().describe(dataset);
  if (!info) co_return context.refused(info.error());
  const auto slice = slice_for(query->slice, *info);
  if (!slice) co_return context.refused(slice.error());
  const auto scale = scale_for(*query, *info);
  if (!scale) co_return context.refused(scale.error());
  HttpResponse response;
  const bool is_raw = query->format == SliceFormat::kRaw;
  add_field(response, "Content-Type", is_raw ? "application/octet-stream" : "image/png");
  add_field(response, "Cache-Control", "no-cache");
  add_plane(response, in_indices(*slice, *info));
  const std::string tag =
      info->content_id == 0 ? "" : tag_of(key_of(*info, *slice, *query, *scale));
  response.is_length_known = needs_body(request.http, tag);
  if (response.is_length_known) {
    if (context.watch) context.watch();
    // Reserves the picture as pixels and as a file; the service reserves the samples.
    const std::size_t picture_bytes = 2 * sizeof(Pixel) * slice->width * slice->height;
    const auto reservation = context.client->reserve(is_raw ? 0 : picture_bytes);
    if (!reservation) co_return context.refused(reservation.error());
    const auto picture = std::make_shared<std::string>();
    UseReply draw = [picture, colors = PictureColors{*scale, query->no_value_color.has_value()}](
                        const DatasetQueryReply& reply) -> Result<void> {
      *picture = picture_of(std::get<SliceReply>(reply), colors);
      return {};
    };
    if (is_raw) draw = nullptr;
    const auto reply = co_await context.service_client->slice(dataset, *slice, std::move(draw));
    if (!reply) co_return context.refused(reply.error());
    add_field(response, "Multitetra-Sample-Spacing", std::to_string(reply->sample_spacing));
    response.body = is_raw ? body_of(reply->values) : body_of(std::move(*picture));
  }
  if (!tag.empty()) apply_conditions(response, request.http, tag);
  co_return response;
}

// Returns {"places":[{"world","index","value","gradient"}]}; value and gradient are null in the
// void.
asio::awaitable<HttpResponse> probe_answer(ResourceRequest request) {
  RequestContext& context = request.context;
  const auto allowed = context.service_client->client_access().check_samples();
  if (!allowed) co_return context.refused(allowed.error());
  const auto probe = parse_probe_query(request.target.query);
  if (!probe) co_return context.refused(probe.error());
  const auto reply = co_await context.service_client->probe(request.path[0], *probe);
  if (!reply) co_return context.refused(reply.error());
  Json places = Json::array();
  for (const ProbedPlace& place : reply->places) places.push_back(json_of(place));
  HttpResponse response = json_answer(200, multitetra::text_of({{"places", std::move(places)}}));
  add_field(response, "Cache-Control", "no-cache");
  co_return response;
}

}  // namespace

Resource slice_resource(const ResourceContext&) {
  return {.name = "slice", .path = "/v1/datasets/{name}/slice", .answer = slice_answer};
}

Resource probe_resource(const ResourceContext&) {
  return {.name = "probe", .path = "/v1/datasets/{name}/probe", .answer = probe_answer};
}

}  // namespace multitetra
