// A server with an HTTP listener on a free local port, running in its own thread.
#pragma once

#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "common/wire/messages.hpp"
#include "server/operations/log.hpp"
#include "server/routes/route_options.hpp"
#include "server/transport/server.hpp"
#include "tests/support/http_client.hpp"
#include "tests/support/websocket_client.hpp"

namespace multitetra::testing {

// A service whose readiness is controlled by the test.
class ReadyWhen : public SurfaceService {
 public:
  ReadyWhen(SurfaceService& service, std::function<bool()> is_ready)
      : service_(service), is_ready_(std::move(is_ready)) {}
  [[nodiscard]] ServiceClientPtr open(ConnectionContextPtr client) override {
    return service_.open(std::move(client));
  }
  [[nodiscard]] std::optional<TileCache::Found> find_tile(
      const ContentDigest& digest, const TileCache::MaySee& may_see) override {
    return service_.find_tile(digest, may_see);
  }
  [[nodiscard]] bool is_ready() const override { return is_ready_(); }
  void join() override { service_.join(); }
  [[nodiscard]] ServiceState state() const override { return service_.state(); }

 private:
  SurfaceService& service_;
  std::function<bool()> is_ready_;
};

// Returns a cache that contains the tile.
inline std::shared_ptr<SurfaceCache> cache_of(const EncodedTile& tile, const std::string& dataset,
                                              std::uint64_t appearance = 0,
                                              std::size_t capacity = 1 << 20) {
  auto cache = std::make_shared<SurfaceCache>(capacity);
  cache->tiles().add({.digest = tile.summary.digest,
                      .cube = tile.summary.cube,
                      .appearance = appearance,
                      .dataset = dataset},
                     tile);
  return cache;
}

class RunningHttpServer {
 public:
  explicit RunningHttpServer(
      CataloguePtr catalogue, HttpOptions options = {}, ServerOptions server = {},
      RouteOptions routes = {}, std::function<bool()> is_ready = [] { return true; })
      : server_(std::move(catalogue), on_a_free_port(std::move(server)),
                {[this, is_ready = std::move(is_ready),
                  listener = http_listener(on_a_free_port(std::move(options)), std::move(routes))](
                     const ServerContext& context) {
                  service_ = std::make_unique<ReadyWhen>(context.service, is_ready);
                  return listener({.io = context.io,
                                   .admission = context.admission,
                                   .service = *service_,
                                   .new_session_runner = context.new_session_runner,
                                   .metrics = context.metrics});
                }}),
        thread_([this] { server_.run(); }) {}
  ~RunningHttpServer() { stop(); }
  RunningHttpServer(const RunningHttpServer&) = delete;
  RunningHttpServer& operator=(const RunningHttpServer&) = delete;

  void stop() {
    server_.stop();
    if (thread_.joinable()) thread_.join();
  }
  void drain() { server_.drain(); }
  [[nodiscard]] Endpoint tcp() const { return server_.endpoint(0); }
  [[nodiscard]] Endpoint http() const { return server_.endpoint(1); }

 private:
  template <typename Options>
  static Options on_a_free_port(Options options) {
    set_log_level(LogLevel::kOff);
    options.listen = {.host = "127.0.0.1", .port = 0};
    return options;
  }

  std::unique_ptr<ReadyWhen> service_;
  Server server_;
  std::thread thread_;
};

// A tokens file with the datasets of each token.
class TokensFile {
 public:
  struct Line {
    std::string name;
    std::string token;  // Empty: clients without a token.
    std::string datasets;
  };
  TokensFile(const std::filesystem::path& folder, const std::vector<Line>& lines)
      : path_(folder / "tokens") {
    std::ofstream file(path_);
    for (const Line& line : lines) {
      file << line.name << ' ';
      if (line.token.empty()) file << "none";
      for (const unsigned char byte : digest_of_token(line.token)) {
        static constexpr const char* kDigits = "0123456789abcdef";
        if (!line.token.empty()) file << kDigits[byte >> 4] << kDigits[byte & 15];
      }
      file << ' ' << line.datasets << '\n';
    }
    file.close();
    std::filesystem::permissions(path_, std::filesystem::perms::owner_read);
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace multitetra::testing
