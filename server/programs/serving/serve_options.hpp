// The options of `multitetra-server serve`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/cli/command.hpp"
#include "server/programs/serving/listener_options.hpp"
#include "server/service/dataset_catalogue.hpp"
#include "server/store/remote_files.hpp"
#include "server/transport/server.hpp"

namespace multitetra {

// Values as given by the user. 0 means no limit.
struct ServeOptions {
  ListenerOptions listeners = {};
  std::vector<std::string> datasets = {};
  int threads = 0;
  std::uint64_t max_triangles = 0;
  double max_request_seconds = 300;
  double max_waiting_seconds = 600;
  std::size_t cache_bytes = std::size_t{512} << 20;
  std::size_t brick_bytes = std::size_t{512} << 20;
  std::string cache_dir = {};
  std::size_t cache_dir_bytes = std::size_t{16} << 30;
  std::string volume_cache = {};  // Empty: that of `view`.
  int store_connections = 8;
  double store_seconds = 30;
  ReadingsSource readings = nullptr;  // Datasets may be missing while their volumes are read.
};

void add_serve_options(Command& command, ServeOptions& options);

[[nodiscard]] RemoteFilesOptions file_options(const ServeOptions& options);

// Throws UsageError, which names the option.
[[nodiscard]] ServerOptions server_options(const ServeOptions& options);

}  // namespace multitetra
