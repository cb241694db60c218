// /v1/tiles/HASH: a cached tile by its digest.
#pragma once

#include "common/mesh/content_digest.hpp"
#include "server/http/request_context.hpp"

namespace multitetra {

// Serves tiles of datasets that the client may see. With an access list, the response is private.
[[nodiscard]] Answer tile_answer(SurfaceService& service, const ContentDigest& digest,
                                 const HttpRequest& request, RequestContext& context);

}  // namespace multitetra
