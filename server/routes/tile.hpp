// /v1/tiles/HASH: a cached tile, by its digest.
#pragma once

#include "common/mesh/content_digest.hpp"
#include "server/http/request_context.hpp"

namespace multitetra {

// Tiles are visible to clients that may see their dataset. Where tokens decide that, the response
// is private.
[[nodiscard]] Answer tile_answer(SurfaceService& service, const ContentDigest& digest,
                                 const HttpRequest& request, RequestContext& context);

}  // namespace multitetra
