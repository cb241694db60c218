// Isosurfaces as files over HTTP: one mesh in one response.
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
  // The options outlive the route.
  explicit IsosurfaceRoute(const RouteOptions& options);

  // Makes nothing for HEAD, nor where the client has it already.
  [[nodiscard]] asio::awaitable<Answer> answer(const std::string& dataset, const Target& target,
                                               const HttpRequest& request, RequestContext& context);

 private:
  // Meshes that are made at the same time: each takes much memory. One of them is a small one, so
  // that it does not wait for large ones, and no address or token has more than one large.
  static constexpr std::size_t kAssembling = 3;

  // Everything that determines the file's bytes.
  struct Wanted {
    DatasetInfo info;
    std::vector<IsosurfaceRequest> requests;  // A surface each.
    std::optional<ScalarRequest> scalars;
    MeshForm form;
    bool is_format_negotiated = false;
    std::string key;  // The same exactly for the same file.
    // In quotes; empty where the dataset has no digest of its content.
    std::string tag;
  };
  [[nodiscard]] Result<Wanted> wanted(const std::string& dataset, const Target& target,
                                      const HttpRequest& request, const RequestContext& context);
  // The surfaces of all isovalues. A budget is shared in proportion to their estimated sizes.
  [[nodiscard]] asio::awaitable<Result<std::vector<Surface>>> surfaces_of(const Wanted& wanted,
                                                                          Caller& caller);
  // nullopt when the temporary folder does not take the file.
  [[nodiscard]] asio::awaitable<Result<std::optional<StoredMesh>>> make(const Wanted& wanted,
                                                                        RequestContext& context);
  const RouteOptions& options_;
  MeshFileCache meshes_;
  Workers assembling_{kAssembling};
};

}  // namespace multitetra
