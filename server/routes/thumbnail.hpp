// Thumbnails of datasets: a small picture of the suggested surface, for lists.
#pragma once

#include <string>

#include "common/base/lru_map.hpp"
#include "common/wire/tile.hpp"
#include "server/http/answer.hpp"
#include "server/http/request_context.hpp"
#include "server/http/target.hpp"
#include "server/service/workers.hpp"

namespace multitetra {

// Used on the executor's thread only.
class ThumbnailRoute {
 public:
  // Returns a PNG of 128 x 96 pixels with a transparent background. Parameters: isovalue (default:
  // the first suggestion) and up, such as -y (default: z). The surface is a preview, made by the
  // service like any other. Makes nothing for HEAD, nor if the client's copy is current.
  [[nodiscard]] asio::awaitable<Answer> answer(const std::string& dataset, const Target& target,
                                               const HttpRequest& request, RequestContext& context);

 private:
  static constexpr std::size_t kMaxCachedBytes = std::size_t{8} << 20;

  LruMap<std::string, SharedBytes> kept_{kMaxCachedBytes};
  Workers drawing_{1};
};

}  // namespace multitetra
