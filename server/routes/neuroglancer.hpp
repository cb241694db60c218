// Neuroglancer's precomputed formats over HTTP: surfaces as multi-resolution meshes, the volume as
// an image.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "common/base/lru_map.hpp"
#include "server/http/answer.hpp"
#include "server/http/request_context.hpp"
#include "server/routes/route.hpp"
#include "server/routes/route_options.hpp"
#include "server/service/workers.hpp"
#include "server/tilesets/neuroglancer.hpp"
#include "server/tilesets/neuroglancer_image.hpp"

namespace multitetra {

// Used on the executor's thread only.
class NeuroglancerRoute {
 public:
  // The options must outlive the route.
  explicit NeuroglancerRoute(const RouteOptions& options) : options_(options) {}

  // A mesh's manifest lists the sizes of all its fragments, so the first request for it, or for one
  // of its files, waits until all are made. After a few seconds it is answered with a retry delay;
  // finished fragments are kept. The service makes each cell as a separate request, with the usual
  // limits. Makes nothing if the client's copy is current.
  [[nodiscard]] asio::awaitable<Answer> answer(const NeuroglancerFile& file,
                                               const HttpRequest& request, RequestContext& context);

 private:
  // The fragments of one segment.
  struct Mesh {
    // Cells that the surface crosses and that are not made yet.
    std::vector<OctreeCube> left;
    MeshFragments fragments = {};
    std::size_t bytes = 0;
    // Set when `left` is empty: as MeshFiles, separate so that sending one retains only that.
    SharedBytes manifest = {};
    SharedBytes data = {};
  };
  using MeshPtr = std::shared_ptr<Mesh>;

  [[nodiscard]] asio::awaitable<Result<SharedBytes>> content(const NeuroglancerFile& file,
                                                             const DatasetInfo& info,
                                                             RequestContext& context);
  [[nodiscard]] asio::awaitable<Result<SharedBytes>> image(const ImageChunk& chunk,
                                                           const DatasetInfo& info,
                                                           RequestContext& context);
  [[nodiscard]] asio::awaitable<Result<MeshPtr>> mesh(const Tileset& tileset,
                                                      RequestContext& context);
  // Makes the first of the remaining cells.
  [[nodiscard]] asio::awaitable<Result<void>> make_fragment(const Tileset& tileset, MeshPtr mesh,
                                                            RequestContext& context);

  static constexpr std::size_t kMaxCachedBytes = std::size_t{256} << 20;
  // The size limit of one mesh, in bytes.
  static constexpr std::size_t kMaxBytes = kMaxCachedBytes / 2;
  static constexpr std::chrono::seconds kMaxManifestWait{8};

  const RouteOptions& options_;
  LruMap<std::string, MeshPtr> meshes_{kMaxCachedBytes};
  Workers writing_{2};
};

}  // namespace multitetra
