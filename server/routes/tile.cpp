#include "server/routes/tile.hpp"

#include "server/http/media.hpp"

namespace multitetra {

Answer tile_answer(SurfaceService& service, const ContentDigest& digest, const HttpRequest& request,
                   RequestContext& context) {
  const Permit& permit = context.caller->permit();
  const auto found = service.find_tile(digest, [&](const std::string& dataset, bool is_shell) {
    return is_shell ? permit.may_see_shells(dataset) : permit.may_see(dataset);
  });
  if (!found) {
    return error_answer(
        404,
        {ErrorCode::kInvalidArgument,
         "The server does not have this tile, or no longer; request it with a stream."},
        context.request_id);
  }
  Answer answer{.body = body_of(found->tile.payload)};
  add_field(answer, "Content-Type",
            found->is_shell ? "application/octet-stream" : media_type(MeshFormat::kDrc));
  add_field(answer, "Cache-Control",
            permit.is_for_all() ? "public, max-age=31536000, immutable"
                                : "private, max-age=31536000, immutable");
  apply_conditions(answer, request, '"' + digest.hex() + '"');
  return answer;
}

}  // namespace multitetra
