// /v1/tiles/HASH: a tile that is at hand, by the digest of its triangles.
#pragma once

#include "common/mesh/content_digest.hpp"
#include "server/http/request_context.hpp"

namespace multitetra {

// Whoever may see a dataset may have its tiles. Where tokens decide that, an answer is for their
// bearer alone.
[[nodiscard]] Answer tile_answer(SurfaceService& service, const ContentDigest& digest,
                                 const HttpRequest& request, RequestContext& context);

}  // namespace multitetra
