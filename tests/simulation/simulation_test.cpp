// Servers, a gateway, a store and many clients in simulated time, with failures of all kinds. Every
// seed is another course of events:
//
//   simulation_test                                            200 seeds
//   MULTITETRA_SEEDS=10000 simulation_test                     more, and how many a minute
//   MULTITETRA_SEED=4711 simulation_test                       one again
#include <chrono>
#include <cstdlib>
#include <iostream>

#include <gtest/gtest.h>

#include "common/base/parse_number.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/operations/log.hpp"
#include "server/service/caching_surface_provider.hpp"
#include "tests/simulation/simulated_client.hpp"
#include "tests/simulation/simulated_server.hpp"
#include "tests/support/fake_steps.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/make_dataset.hpp"

namespace multitetra::simulation {
namespace {

using testing::FakeSteps;

// A dataset with another description but the same surfaces, such as a file that was replaced.
class Replaced : public FakeSteps {
 public:
  Replaced(const std::string& name, std::uint64_t version) : FakeSteps(name) {
    info_ = FakeSteps::info();
    info_.content_id = version;
  }
  [[nodiscard]] const DatasetInfo& info() const override { return info_; }

 private:
  DatasetInfo info_;
};

// A real surface in many tiles, whose steps are made once for all seeds.
const std::shared_ptr<const SurfaceProvider>& gyroid() {
  static const std::shared_ptr<const SurfaceProvider> made =
      std::make_shared<CachingSurfaceProvider>(
          std::make_shared<SurfaceExtractor>(
              make_dataset(testing::fields::gyroid(17, 0.1, 1), "gyroid")),
          std::make_shared<SurfaceCache>(std::size_t{1} << 28));
  return made;
}

CataloguePtr catalogue_of_version(std::uint64_t version) {
  auto catalogue = std::make_shared<DatasetCatalogue>();
  catalogue->add(std::make_shared<Replaced>("fake", version));
  catalogue->add(gyroid());
  return catalogue;
}

ContentDigest final_digest_of(const SurfaceProvider& source, const IsosurfaceRequest& request) {
  static std::map<std::string, ContentDigest> known;
  const std::string key =
      serialize(ClientMessage(Estimate{.dataset = source.info().name, .request = request}));
  const auto [at, is_new] = known.try_emplace(key);
  if (!is_new) return at->second;
  ContentDigest sum;
  for (const EncodedTile& tile : source.make(final_step(request), {}).tiles) {
    sum += tile.summary.digest;
  }
  return at->second = sum;
}

Wish random_wish(World& world, const DatasetCatalogue& catalogue) {
  Wish wish;
  wish.dataset = world.chance(0.2) ? "gyroid" : "fake";
  wish.request.isovalue = wish.dataset == "fake" ? 1 : (world.chance(0.5) ? 0.1 : 0.4);
  wish.request.error = world.chance(0.5) ? 0.5 : 2;
  wish.request.simplify = false;
  wish.steps = world.chance(0.8) ? StepPolicy::kProgressive : StepPolicy::kFinalOnly;
  wish.final_digest = final_digest_of(*catalogue.find(wish.dataset), wish.request);
  return wish;
}

struct Outcome {
  std::vector<std::string> broken_promises;
  double seconds = 0;  // Simulated.
  std::size_t surfaces = 0;
};

Outcome run(std::uint64_t seed) {
  Outcome outcome;
  World world(seed);
  const auto report = [&outcome](const std::string& broken) {
    outcome.broken_promises.push_back(broken);
  };
  Weather weather{.cuts = world.chance(0.5) ? world.uniform(0, 0.7) : 0,
                  .lies = world.chance(0.2) ? 0.3 : 0};
  Store store{.catalogue = catalogue_of_version(1),
              .failures = world.chance(0.3) ? world.uniform(0, 0.3) : 0};
  SimulatedServer first(world, store, 3);
  SimulatedServer second(world, store, 2);
  SimulatedGateway gateway(world, {&first, &second}, weather);
  const std::vector<Peer*> peers = {&first, &gateway};

  std::vector<std::shared_ptr<SimulatedClient>> clients;
  const std::size_t count = 1 + world.below(50);
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<Wish> wishes;
    for (std::size_t k = 1 + world.below(2); k > 0; --k) {
      wishes.push_back(random_wish(world, *store.catalogue));
    }
    clients.push_back(
        std::make_shared<SimulatedClient>(world, peers, weather, std::move(wishes), report));
    world.after(world.uniform(0, 20), [client = clients.back()] { client->start(); });
  }
  if (world.chance(0.3)) {
    world.after(world.uniform(0, 30), [&store] { store.catalogue = catalogue_of_version(2); });
  }

  constexpr double kLongest = 24 * 3600;
  const auto all_done = [&] {
    return std::all_of(clients.begin(), clients.end(), [](const auto& c) { return c->is_done(); });
  };
  if (!world.run(kLongest, all_done) || !all_done()) report("a client waits for ever");
  for (const auto& client : clients) client->leave();
  outcome.seconds = world.now();
  if (!world.run(world.now() + kLongest, [] { return false; })) report("events never end");
  for (SimulatedServer* const server : {&first, &second}) {
    if (server->jobs() > 0) report("jobs are left");
    if (server->streams() > 0) report("a stream was forgotten");
    if (server->connections() > 0) report("a connection was forgotten");
    // Of each connection one job waits, and one may still run for a stream that was stopped.
    if (server->most_jobs() > 20 * count) report("jobs pile up");
  }
  if (gateway.relays() > 0) report("the gateway has forgotten a client");
  for (const auto& client : clients) outcome.surfaces += client->surfaces();
  return outcome;
}

std::uint64_t number_in(const char* variable, std::uint64_t otherwise) {
  const char* const text = std::getenv(variable);
  return text ? parse_number<std::uint64_t>(text).value_or(otherwise) : otherwise;
}

TEST(Simulation, KeepsEveryPromise) {
  set_log_level(LogLevel::kOff);
  const std::uint64_t one = number_in("MULTITETRA_SEED", 0);
  const std::uint64_t seeds = one ? 1 : number_in("MULTITETRA_SEEDS", 200);
  const auto start = std::chrono::steady_clock::now();
  double simulated = 0;
  std::size_t surfaces = 0;
  for (std::uint64_t i = 0; i < seeds; ++i) {
    const std::uint64_t seed = one ? one : i + 1;
    const Outcome outcome = run(seed);
    simulated += outcome.seconds;
    surfaces += outcome.surfaces;
    for (const std::string& broken : outcome.broken_promises) {
      ADD_FAILURE() << "MULTITETRA_SEED=" << seed << ": " << broken;
    }
    if (HasFailure() && !one) break;
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  std::cout << seeds << " seeds, " << surfaces << " surfaces, " << simulated / 3600
            << " simulated hours; " << 60 * static_cast<double>(seeds) / seconds.count()
            << " seeds a minute" << std::endl;
}

TEST(Simulation, IsTheSameForTheSameSeed) {
  set_log_level(LogLevel::kOff);
  for (const std::uint64_t seed : {3U, 7U}) {
    const Outcome first = run(seed);
    const Outcome again = run(seed);
    EXPECT_EQ(first.seconds, again.seconds);
    EXPECT_EQ(first.surfaces, again.surfaces);
  }
}

}  // namespace
}  // namespace multitetra::simulation
