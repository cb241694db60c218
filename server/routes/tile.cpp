// /v1/tiles/HASH: a cached tile by its digest.
#include "common/mesh/content_digest.hpp"
#include "server/http/media.hpp"
#include "server/routes/resource.hpp"

namespace multitetra {
namespace {

HttpResponse tile_answer(SurfaceService& service, const ResourceRequest& request) {
  RequestContext& context = request.context;
  const std::string& hash = request.path[0];
  const auto digest = ContentDigest::from_hex(hash);
  if (!digest) {
    return context.refused({ErrorCode::kInvalidArgument,
                            "\"" + hash +
                                "\" is not the digest of a tile, which has 32 hexadecimal "
                                "digits."});
  }
  const ClientAccess& client_access = context.service_client->client_access();
  const auto found = service.find_tile(*digest, [&](const std::string& dataset, bool is_shell) {
    return is_shell ? client_access.may_see_shells(dataset) : client_access.may_see(dataset);
  });
  if (!found) {
    return error_answer(
        404,
        {ErrorCode::kInvalidArgument,
         "The server does not have this tile, or no longer; request it with a stream."},
        context.request_id);
  }
  HttpResponse response{.body = body_of(found->tile.payload)};
  add_field(response, "Content-Type",
            found->is_shell ? "application/octet-stream" : media_type(MeshFormat::kDrc));
  add_field(response, "Cache-Control",
            client_access.is_for_all() ? "public, max-age=31536000, immutable"
                                       : "private, max-age=31536000, immutable");
  apply_conditions(response, request.http, '"' + digest->hex() + '"');
  return response;
}

}  // namespace

Resource tile_resource(const ResourceContext& context) {
  return {.name = "tile",
          .path = "/v1/tiles/{hash}",
          .kind = Resource::Kind::kCached,
          .answer = [&context](ResourceRequest request) -> asio::awaitable<HttpResponse> {
            co_return tile_answer(context.server.service, request);
          }};
}

}  // namespace multitetra
