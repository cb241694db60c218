// What a listener for HTTP allows its clients.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/net/endpoint.hpp"
#include "common/net/frame.hpp"
#include "common/net/net.hpp"
#include "common/wire/tile.hpp"
#include "server/http/viewer_files.hpp"
#include "server/stream/dataset_catalogue.hpp"
#include "server/stream/tile_cache.hpp"
#include "server/transport/connection_options.hpp"
#include "server/transport/listener.hpp"

namespace multitetra {

inline constexpr std::uint16_t kDefaultHttpPort = 7480;

// What the listener offers besides conversations. Called on its thread; what is empty is not
// offered.
struct HttpHooks {
  // A tile without normals that is at hand, of a dataset that may be seen.
  std::function<std::optional<EncodedTile>(const ContentDigest&, const TileCache::MaySee&)>
      find_tile = {};
  // What others say that the bearer of a token may see, besides the access list. Empty: nothing.
  std::function<asio::awaitable<Result<CataloguePtr>>(std::string token)> catalogue_of = {};
  // Whether new work is welcome, besides what the admission of the server says. Empty: always.
  std::function<bool()> is_ready = {};
};

struct HttpOptions {
  Endpoint listen{.host = "127.0.0.1", .port = kDefaultHttpPort};  // Port 0: a free one.
  // Each for itself: TLS, the first byte of the first request, a request's header from its first
  // byte on, a WebSocket's first Hello.
  std::chrono::milliseconds handshake_timeout{10'000};
  std::chrono::milliseconds keep_alive_timeout{60'000};  // Between two requests.
  std::chrono::milliseconds idle_timeout{120'000};  // A WebSocket that answers no ping for so long.
  std::chrono::milliseconds write_timeout{60'000};  // For one message, or 256 KiB of an answer.
  std::chrono::milliseconds linger{1'000};     // For the client to read our last words and hang up.
  std::uint32_t max_header_bytes = 16 * 1024;  // Request line and header.
  std::uint32_t max_message_bytes = kMaxClientFrameBytes;  // Of a WebSocket, after Hello,
  std::uint32_t max_hello_bytes = kMaxHelloFrameBytes;     // and before.
  std::optional<int> send_buffer_bytes = std::nullopt;     // None leaves it to the system.
  // Under which a proxy shows the listener, as parse_base_path gives it; requests may have it or
  // not.
  std::string base_path = {};
  // "https://example.org": pages from there may read answers and open WebSockets, besides those
  // of this listener itself. "*" allows all.
  std::vector<std::string> allowed_origins = {};
  // Names by which the listener may be asked, as is_allowed_host takes them; "*" allows all.
  std::vector<std::string> allowed_hosts = {"*"};
  // Of /v1/datasets/NAME/isosurface: the most triangles of one response, which take about 120 bytes
  // of memory each while one is made; and how many bytes of files are being sent or kept for the
  // next requests, and where: they have no names. 0: none are kept.
  std::uint64_t max_mesh_triangles = 4'000'000;
  std::uint64_t mesh_cache_bytes = std::uint64_t{512} << 20;
  // Who takes a file more slowly, after write_timeout, holds up others and is given up. 0: nobody.
  std::uint64_t min_mesh_bytes_per_second = 32 * 1024;
  std::filesystem::path temporary_folder = std::filesystem::temp_directory_path();
  std::shared_ptr<const ViewerFiles> viewer = std::make_shared<const ViewerFiles>();
  HttpHooks hooks = {};

  // Of a WebSocket, as those of other listeners.
  [[nodiscard]] ConnectionOptions connection() const {
    return {.handshake_timeout = handshake_timeout,
            .write_timeout = write_timeout,
            .linger = linger,
            .max_message_bytes = max_message_bytes,
            .max_hello_bytes = max_hello_bytes,
            .send_buffer_bytes = send_buffer_bytes};
  }
};

// For servers and gateways. Throws, when it is called, AddressError that names the address when
// that cannot be listened on.
[[nodiscard]] MakeListener http_listener(HttpOptions options);

// "HOST:PORT", also behind "http://". kInvalidArgument, with the text and an example, otherwise.
[[nodiscard]] Result<Endpoint> parse_http_endpoint(std::string_view text);
// "http://HOST:PORT", or "https://HOST:PORT".
[[nodiscard]] std::string http_url(const Endpoint& endpoint, bool is_secure = false);

}  // namespace multitetra
