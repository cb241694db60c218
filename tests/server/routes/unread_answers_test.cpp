// Clients that send requests and do not read the answers: on all routes the memory of the server
// stays within its documented bounds (server/operations/README.md, "Memory").
#include <deque>
#include <fstream>

#include <unistd.h>

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "server/operations/prometheus_metrics.hpp"
#include "server/tilesets/neuroglancer.hpp"
#include "tests/support/fake_steps.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/running_http_server.hpp"
#include "tests/support/served_datasets.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

using testing::HttpClient;
using testing::RunningHttpServer;

constexpr std::size_t kMiB = std::size_t{1} << 20;
constexpr std::size_t kQueueBytes = 32 * kMiB;  // A share may take a quarter.
constexpr std::size_t kCacheBytes = 8 * kMiB;
constexpr std::size_t kClients = 60;
// Bytes per connection: coroutines, a header, a chunk of a file.
constexpr std::size_t kBytesOfAConnection = 48 * 1024;
// Two workers, each with two copies and a picture of a slice of 2 MiB, and retained memory.
constexpr std::size_t kWorkerBytes = 24 * kMiB;

// A cached tile larger than the system's socket buffers. Tiles are sent without a copy.
EncodedTile large_tile() {
  EncodedTile tile = testing::fine_tiles().front();
  tile.payload = std::make_shared<const std::string>(4 * kMiB, 'x');
  return tile;
}

// A client with an address of its own and a tiny receive buffer.
class UnreadingClient {
 public:
  UnreadingClient(const Endpoint& at, std::size_t number) : socket_(io_, tcp::v4()) {
    socket_.set_option(asio::socket_base::receive_buffer_size(4096));
    const auto last = static_cast<unsigned char>(2 + number % 6);
    socket_.bind({asio::ip::address_v4({127, 0, 0, last}), 0});
    socket_.connect({asio::ip::make_address(at.host), at.port});
  }
  void request(const std::string& path) {
    asio::write(socket_, asio::buffer("GET " + path + " HTTP/1.1\r\nHost: localhost\r\n\r\n"));
  }
  // Waits for the first bytes of the answer and returns its status.
  std::string status() {
    std::string line(12, ' ');
    error_code error;
    asio::read(socket_, asio::buffer(line), error);
    return line.substr(9);
  }

 private:
  asio::io_context io_;
  tcp::socket socket_;
};

class UnreadAnswerMemory : public ::testing::TestWithParam<std::string> {
 protected:
  static CataloguePtr catalogue() {
    const Volume volume = testing::fields::sampled<std::uint16_t>(
        {33, 33, 33},
        [](int x, int y, int z) { return (x - 16) * (x - 16) + (y - 16) * (y - 16) + 9 * z; });
    return testing::catalogue_with({make_dataset(volume, "head")});
  }
  static HttpOptions http() {
    HttpOptions options;
    options.connection.send_buffer_bytes = 4096;
    return options;
  }
  static ServerOptions server() {
    ServerOptions options;
    options.admission.queue_bytes = kQueueBytes;
    options.admission.requests = {};
    options.service.workers = 2;
    options.service.cache = testing::cache_of(large_tile(), "head", 0, kCacheBytes);
    options.metrics = std::make_shared<PrometheusMetrics>();
    return options;
  }

  // A viewer with a file larger than the system's socket buffers.
  RouteOptions routes() {
    folder_.file("viewer/index.html", "<p>viewer");
    folder_.file("viewer/assets/app.js", std::string(4 * kMiB, ' '));
    RouteOptions options;
    options.viewer = std::make_shared<ViewerFiles>(folder_.path() / "viewer");
    return options;
  }
  // Returns the path of the surface in the root of a tileset.
  [[nodiscard]] std::string path_of_cell() const {
    const std::string tileset = "/v1/3dtiles/head/iso/200/tileset.json";
    const auto json = nlohmann::json::parse(HttpClient(server_.http()).get(tileset).body());
    const auto uri = json.at("root").at("content").at("uri").get<std::string>();
    return tileset.substr(0, tileset.rfind('/') + 1) + uri;
  }
  [[nodiscard]] std::string path() const {
    return GetParam() == "a cell of 3D Tiles" ? path_of_cell() : GetParam();
  }

  TemporaryFolder folder_;
  RunningHttpServer server_{catalogue(), http(), server(), routes()};
};

TEST_P(UnreadAnswerMemory, StaysWithinTheDocumentedLimit) {
  const std::string requested = path();
  const std::size_t before = resident_bytes();
  std::deque<UnreadingClient> clients;
  for (std::size_t i = 0; i < kClients; ++i) {
    clients.emplace_back(server_.http(), i);
    clients.back().request(requested);
  }
  std::size_t answered = 0;
  for (UnreadingClient& client : clients) {
    const std::string status = client.status();
    answered += status == "200" ? 1U : 0U;
    EXPECT_TRUE(status == "200" || status == "503") << status;
  }
  EXPECT_GT(answered, 0U);
  const std::size_t used = std::max(resident_bytes(), before) - before;
  EXPECT_LT(used, kQueueBytes + kCacheBytes + kClients * kBytesOfAConnection + kWorkerBytes);
  // Other clients are still served.
  HttpClient newcomer(server_.http());
  EXPECT_EQ(newcomer.get("/v1/datasets/head/slice?width=64&height=64").result_int(), 200U);
  EXPECT_EQ(newcomer.get("/v1/datasets/head/isosurface?isovalue=200&error=1").result_int(), 200U);
}

INSTANTIATE_TEST_SUITE_P(
    OfAllRoutes, UnreadAnswerMemory,
    ::testing::Values("/v1/datasets/head/slice?format=raw&width=1024&height=512",
                      "/v1/datasets/head/slice?width=1024&height=512",
                      "/v1/datasets/head/isosurface?isovalue=200&error=0&format=stl",
                      "/v1/3dtiles/head/iso/200/tileset.json", "/v1/neuroglancer/head/image/info",
                      "/v1/neuroglancer/head/image/1_1_1/0-33_0-33_0-16",
                      "/v1/neuroglancer/head/surfaces/" + std::to_string(segment_of(200)),
                      "/v1/datasets/head", "/v1/datasets", "/v1/openapi.json", "/metrics",
                      "a cell of 3D Tiles",
                      "/v1/tiles/" + testing::fine_tiles().front().summary.digest.hex(),
                      "/v1/datasets/head/probe?at=1,2,3&at=4,5,6", "/", "/assets/app.js"));

}  // namespace
}  // namespace multitetra
