// Isosurfaces as files over HTTP: one mesh in one response.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/http/answer.hpp"
#include "server/http/http_options.hpp"
#include "server/http/mesh_response.hpp"
#include "server/http/request_context.hpp"
#include "server/http/surface_query.hpp"
#include "server/http/target.hpp"
#include "server/stream/lru_map.hpp"
#include "server/stream/workers.hpp"

namespace multitetra {

class SurfaceService {
 public:
  // The options outlive the service.
  explicit SurfaceService(const HttpOptions& options);

  // `one_shot` is greeted. Makes nothing for HEAD, nor where the client has it already.
  [[nodiscard]] asio::awaitable<Answer> answer(const std::string& dataset, const Target& target,
                                               const HttpRequest& request, OneShotSession& one_shot,
                                               RequestContext& context);

 private:
  // What was asked for, in all that the file is a function of.
  struct Wanted {
    DatasetInfo info;
    IsosurfaceRequest request;
    MeshForm form;
    bool is_format_negotiated = false;
    std::string key;  // The same exactly for the same file.
    std::string tag;  // In quotes; empty where the dataset does not tell its content.
  };
  [[nodiscard]] asio::awaitable<Result<Wanted>> wanted(const std::string& dataset,
                                                       const Target& target,
                                                       const HttpRequest& request,
                                                       OneShotSession& one_shot);
  [[nodiscard]] asio::awaitable<Result<StoredMesh>> make(const Wanted& wanted,
                                                         OneShotSession& one_shot,
                                                         RequestContext& context);
  // Of a mesh among those that are kept.
  [[nodiscard]] std::size_t weight_of(const StoredMesh& mesh) const;

  const HttpOptions& options_;
  LruMap<std::string, StoredMesh> meshes_;
  Workers assembling_{1};  // One mesh at a time: each takes much memory.
};

}  // namespace multitetra
