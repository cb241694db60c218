// Streams surfaces that were never requested before, from a server in this process to a client that
// assembles and checks them, over a link of a given speed.
//
//   MeasuredServer server(extractor, /*workers=*/2, {.bytes_per_second = 1.25e6}, ways().front());
//   const MeasuredStream stream = server.stream({.isovalue = 300.5, .error = 0.5, .simplify = true});
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "client/library/surface_stream.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/service/caching_surface_provider.hpp"
#include "tests/bench/shaped_link.hpp"
#include "tests/support/running_server.hpp"

namespace multitetra {

// The capabilities that a client declares.
struct ClientWay {
  std::string name;
  std::vector<PayloadCodec> codecs = ClientOptions{}.codecs;
  MeshUse use = MeshUse::kKeep;
  StepPolicy steps = StepPolicy::kProgressive;
  // Whether it reports its measured speed of decoding and checking, as the viewer does.
  bool reports_rate = false;
};

inline const std::vector<ClientWay>& ways() {
  static const std::vector<ClientWay> all = {
      {.name = "draco", .codecs = {PayloadCodec::kDracoLattice}},
      {.name = "samples"},
      {.name = "display", .use = MeshUse::kDisplay},
      {.name = "viewer", .use = MeshUse::kDisplay, .reports_rate = true}};
  return all;
}

struct LinkSpeed {
  double bytes_per_second = 0;  // 0: unlimited.
};

struct MeasuredStep {
  FetchedStep fetched;
  std::uint64_t bytes_until_then = 0;  // Payloads of all steps up to this one.
};
using MeasuredStream = std::vector<MeasuredStep>;

// Returns the first step within the error with the topology of the full surface; null: none.
inline const MeasuredStep* certified_step(const MeasuredStream& stream, double error_world) {
  for (const MeasuredStep& step : stream) {
    const StepBegin& begin = step.fetched.step->begin;
    if (preserves_topology(begin) && begin.error_bound_world <= error_world) return &step;
  }
  return nullptr;
}

// Measures how many triangles per second a client decodes and checks: the viewer's rule, see
// client/web/src/stream/step_speed.ts.
class ClientRate {
 public:
  [[nodiscard]] double triangles_per_second() const { return per_second_; }
  void note(std::size_t triangles, double seconds) {
    if (triangles < 5000 || seconds <= 0) return;
    per_second_ += (static_cast<double>(triangles) / seconds - per_second_) / 2;
  }

 private:
  double per_second_ = 500'000;
};

template <typename T>
T value_of(ClientResult<T> result) {
  if (!result) throw std::runtime_error(result.error().error.text);
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}

// Caches no surfaces; its cost estimates are learned from one stream to the next.
class MeasuredServer {
 public:
  MeasuredServer(std::shared_ptr<const SurfaceExtractor> extractor, std::size_t workers,
                 LinkSpeed link, ClientWay way)
      : info_(extractor->dataset().info),
        way_(std::move(way)),
        server_(catalogue_of(std::move(extractor)), {.service = {.workers = workers}}) {
    if (link.bytes_per_second > 0) link_.emplace(server_.endpoint(), link.bytes_per_second);
    client_.emplace(value_of(
        Client::connect(link_ ? link_->endpoint() : server_.endpoint(), {.codecs = way_.codecs})));
    (void)value_of(client_->list_datasets());
  }

  MeasuredStream stream(const IsosurfaceRequest& request) {
    DecodedTileCache tiles({.tiles = 4096, .triangles = 20'000'000});
    SurfaceStream stream(*client_, tiles);
    Clock::time_point last_tile = Clock::now();
    stream.set_tile_listener([&](const auto&...) { last_tile = Clock::now(); });
    value_of(stream.open(
        info_, {.dataset = info_.name,
                .request = request,
                .steps = way_.steps,
                .triangles_per_second = way_.reports_rate ? rate_.triangles_per_second() : 0,
                .use = way_.use}));
    MeasuredStream all;
    std::uint64_t bytes = 0;
    for (;;) {
      StreamUpdate news = value_of(stream.next(std::chrono::seconds(10)));
      if (auto* step = std::get_if<FetchedStep>(&news)) {
        rate_.note(step->step->mesh.triangles.size(),
                   std::chrono::duration<double>(Clock::now() - last_tile).count());
        bytes += step->step->end.payload_bytes;
        all.push_back({.fetched = std::move(*step), .bytes_until_then = bytes});
      }
      if (std::holds_alternative<StreamEnded>(news)) return all;
    }
  }

 private:
  using Clock = std::chrono::steady_clock;

  static CataloguePtr catalogue_of(std::shared_ptr<const SurfaceExtractor> extractor) {
    auto catalogue = std::make_shared<DatasetCatalogue>();
    catalogue->add(std::make_shared<CachingSurfaceProvider>(std::move(extractor)));
    return catalogue;
  }

  DatasetInfo info_;
  ClientWay way_;
  testing::RunningServer server_;
  std::optional<ShapedLink> link_;
  std::optional<Client> client_;
  ClientRate rate_;
};

}  // namespace multitetra
