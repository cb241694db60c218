// Isosurfaces as files over HTTP: one file per response.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/http/answer.hpp"
#include "server/http/request_context.hpp"
#include "server/http/target.hpp"
#include "server/routes/detail/mesh_file.hpp"
#include "server/routes/detail/mesh_file_cache.hpp"
#include "server/routes/detail/mesh_query.hpp"
#include "server/routes/route_options.hpp"
#include "server/service/workers.hpp"

namespace multitetra {

class IsosurfaceRoute {
 public:
  // The options must outlive the route.
  explicit IsosurfaceRoute(const RouteOptions& options);

  // Makes nothing for HEAD, nor if the client's copy is current.
  [[nodiscard]] asio::awaitable<Answer> answer(const std::string& dataset, const Target& target,
                                               const HttpRequest& request, RequestContext& context);

 private:
  // Meshes made at the same time, limited because each takes much memory. One worker is reserved
  // for small meshes, and a share has at most one large one.
  static constexpr std::size_t kMaxConcurrentMeshes = 3;

  // Everything that determines the file's bytes.
  struct RequestedFile {
    DatasetInfo info;
    std::vector<IsosurfaceRequest> requests;  // One per surface.
    std::optional<ScalarRequest> scalars;
    MeshForm form;
    bool is_format_negotiated = false;
    std::string key;  // Identifies the file's bytes.
    // Quoted; empty if the dataset has no content digest.
    std::string tag;
  };
  [[nodiscard]] Result<RequestedFile> requested_file(const std::string& dataset,
                                                     const Target& target,
                                                     const HttpRequest& request,
                                                     const RequestContext& context);
  // Returns the surfaces of `requests`. They share a budget in proportion to their estimated sizes.
  [[nodiscard]] asio::awaitable<Result<std::vector<Surface>>> surfaces_of(
      const RequestedFile& wanted, std::vector<IsosurfaceRequest> requests, Caller& caller);
  struct Made {
    // Absent if the temporary folder is not writable.
    std::optional<StoredMesh> file;
    // The number of triangles of the whole surfaces.
    std::uint64_t triangles = 0;
  };
  [[nodiscard]] asio::awaitable<Result<Made>> make(const RequestedFile& wanted,
                                                   std::vector<IsosurfaceRequest> requests,
                                                   RequestContext& context);
  // Makes the wanted file. A budget of bytes is one of the file: a budget of triangles that is
  // corrected by the size of the file made with it.
  [[nodiscard]] asio::awaitable<Result<std::optional<StoredMesh>>> make(const RequestedFile& wanted,
                                                                        RequestContext& context);
  const RouteOptions& options_;
  MeshFileCache meshes_;
  Workers assembling_{kMaxConcurrentMeshes};
};

}  // namespace multitetra
