// A surface by the service of this process: the call that an HTTP request makes, without a socket.
#pragma once

#include <memory>

#include "common/request/isosurface_request.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/service/surface.hpp"

namespace multitetra {

// Requires a validated request. Throws what prevented the surface.
[[nodiscard]] Surface local_surface(const std::shared_ptr<const SurfaceExtractor>& extractor,
                                    const IsosurfaceRequest& request);

}  // namespace multitetra
