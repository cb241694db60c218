// Options and limits of the routes of an HTTP listener.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "server/http/http_options.hpp"
#include "server/routes/one_time_link.hpp"
#include "server/routes/viewer_files.hpp"
#include "server/transport/listener.hpp"

namespace multitetra {

struct RouteOptions {
  // For /v1/datasets/NAME/isosurface: the most triangles of one response, which take about 120
  // bytes of memory each while it is made; the most bytes of files being sent or cached (0: no
  // cache); and the folder of these unnamed files.
  std::uint64_t max_mesh_triangles = 4'000'000;
  std::uint64_t mesh_cache_bytes = std::uint64_t{512} << 20;
  // Smaller files stay in memory.
  std::uint64_t max_mesh_bytes_in_memory = std::uint64_t{1} << 20;
  std::filesystem::path temporary_folder = std::filesystem::temp_directory_path();
  std::shared_ptr<const ViewerFiles> viewer = std::make_shared<const ViewerFiles>();
  std::shared_ptr<OneTimeLink> opening = nullptr;  // Of the browser that the server starts, if any.
};

// Makes a listener for HTTP and WebSockets with all routes. When called, throws AddressError, which
// names the address, if it cannot listen.
[[nodiscard]] MakeListener http_listener(HttpOptions options, RouteOptions routes = {});

}  // namespace multitetra
