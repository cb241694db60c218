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

namespace multitetra {

// On the executor's thread alone.
class NeuroglancerRoute {
 public:
  // The options outlive the route.
  explicit NeuroglancerRoute(const RouteOptions& options) : options_(options) {}

  // A mesh's manifest lists the sizes of all its fragments, so the first request for it, or for a
  // file that it lists, waits until all are made; after a few seconds it is answered with a delay
  // for a retry, and what was made until then is kept. The service makes all of it cell by cell, so
  // a mesh has the limits of as many requests. Nothing is made where the client has it already.
  [[nodiscard]] asio::awaitable<Answer> answer(const NeuroglancerFile& file,
                                               const HttpRequest& request, RequestContext& context);

 private:
  // The fragments of one segment.
  struct Mesh {
    // The remaining cells of the tree: crossed and not yet made.
    std::vector<OctreeCube> left;
    MeshFragments fragments = {};
    std::size_t bytes = 0;
    // When nothing is left: as MeshFiles, each for itself, so that sending one keeps only that.
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
  [[nodiscard]] asio::awaitable<Result<MeshPtr>> mesh(const CellTree& tree,
                                                      RequestContext& context);
  // Makes the first of the cells that are left.
  [[nodiscard]] asio::awaitable<Result<void>> make_fragment(const CellTree& tree, MeshPtr mesh,
                                                            RequestContext& context);

  static constexpr std::size_t kKeptBytes = std::size_t{256} << 20;
  // The most bytes of one mesh.
  static constexpr std::size_t kMostBytes = kKeptBytes / 2;
  static constexpr std::chrono::seconds kPatience{8};

  const RouteOptions& options_;
  LruMap<std::string, MeshPtr> meshes_{kKeptBytes};
  Workers writing_{2};
};

}  // namespace multitetra
