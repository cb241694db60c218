// Servers, a gateway, a store and many clients in simulated time, with failures of all kinds. Every
// seed is another course of events:
//
//   simulation_test                                            100 seeds
//   MULTITETRA_SEEDS=10000 simulation_test                     more, and how many a minute
//   MULTITETRA_FIRST_SEED=10001 MULTITETRA_SEEDS=...           others
//   MULTITETRA_SEED=4711 simulation_test                       one again
#include <array>
#include <chrono>
#include <cstdlib>
#include <iostream>
#include <map>
#include <optional>
#include <span>

#include <gtest/gtest.h>

#include "common/base/in_parallel.hpp"
#include "common/base/parse_number.hpp"
#include "server/dataset/prepared_file.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/operations/log.hpp"
#include "server/service/caching_surface_provider.hpp"
#include "tests/simulation/simulated_client.hpp"
#include "tests/simulation/simulated_disk.hpp"
#include "tests/simulation/simulated_server.hpp"
#include "tests/support/fake_steps.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/make_dataset.hpp"
#include "tests/support/memory_source.hpp"

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

// The two versions of a prepared file that is read from a bad disk.
const std::string& stored_file(std::uint64_t version) {
  static const std::array<std::string, 2> files = [] {
    std::array<std::string, 2> made;
    for (std::size_t i = 0; i < made.size(); ++i) {
      const TemporaryFolder folder;
      prepare(*source_of(testing::fields::gyroid(14, 0.1, 7 + i)), {.name = "stored"},
              folder.path() / "stored.mtd", {});
      made[i] = bytes_of_file(folder.path() / "stored.mtd");
    }
    return made;
  }();
  return files.at(version - 1);
}

std::shared_ptr<const SurfaceProvider> provider_of(std::shared_ptr<const ByteSource> source,
                                                   std::size_t cache_bytes) {
  const PreparedFile file("stored", std::move(source));
  return std::make_shared<CachingSurfaceProvider>(
      std::make_shared<SurfaceExtractor>(dataset_in(file, "stored")),
      std::make_shared<SurfaceCache>(cache_bytes));
}

// The datasets of a world, and what may happen to them.
class Datasets {
 public:
  explicit Datasets(World& world) : world_(world) {
    if (world.chance(0.5)) {
      folder_.emplace();
      cache_.emplace(folder_->path(), world.chance(0.5) ? 16 * SimulatedDisk::kBlock : 1 << 20);
    }
    store_.catalogue = catalogue_of_version(1);
    faults_ = {.failures = world.chance(0.3) ? world.uniform(0, 0.1) : 0,
               .lies = world.chance(0.3) ? world.uniform(0, 0.1) : 0,
               .full = world.chance(0.5) ? world.uniform(0, 1) : 0};
    store_.failures = world.chance(0.3) ? world.uniform(0, 0.3) : 0;
  }
  // Other files take the places of the first ones.
  void replace() {
    const Faults faults = std::exchange(faults_, Faults());
    is_first_ = false;
    store_.catalogue = catalogue_of_version(2);
    faults_ = faults;
  }
  [[nodiscard]] const Store& store() const { return store_; }
  [[nodiscard]] bool may_lie() const { return faults_.lies > 0; }

 private:
  CataloguePtr catalogue_of_version(std::uint64_t version) {
    auto catalogue = std::make_shared<DatasetCatalogue>();
    catalogue->add(std::make_shared<Replaced>("fake", version));
    catalogue->add(gyroid());
    const auto disk = std::make_shared<const SimulatedDisk>(
        world_, faults_, std::as_bytes(std::span(stored_file(version))),
        "stored-" + std::to_string(version), version == 1 ? is_first_ : is_second_,
        cache_ ? &*cache_ : nullptr);
    catalogue->add(provider_of(disk, world_.chance(0.3) ? 0 : std::size_t{1} << 24));
    return catalogue;
  }

  World& world_;
  std::optional<TemporaryFolder> folder_;
  std::optional<DiskCache> cache_;
  Faults faults_;
  bool is_first_ = true;
  bool is_second_ = true;
  Store store_;
};

ContentDigest final_digest_of(const SurfaceProvider& source, const IsosurfaceRequest& request) {
  static std::map<std::string, ContentDigest> known;
  const std::string key =
      serialize(ClientMessage(Estimate{.dataset = source.info().name, .request = request})) +
      std::to_string(source.info().content_id);
  const auto [at, is_new] = known.try_emplace(key);
  if (!is_new) return at->second;
  ContentDigest sum;
  for (const EncodedTile& tile : source.make(final_step(request), {}).tiles) {
    sum += tile.summary.digest;
  }
  return at->second = sum;
}

// Both versions of a dataset, without faults.
const std::vector<std::shared_ptr<const SurfaceProvider>>& versions_of(const std::string& name) {
  static const auto in_memory = [](std::uint64_t version) {
    return provider_of(
        std::make_shared<MemorySource>(std::as_bytes(std::span(stored_file(version)))), 0);
  };
  static const std::map<std::string, std::vector<std::shared_ptr<const SurfaceProvider>>> all = {
      {"fake", {std::make_shared<Replaced>("fake", 1), std::make_shared<Replaced>("fake", 2)}},
      {"gyroid", {gyroid()}},
      {"stored", {in_memory(1), in_memory(2)}}};
  return all.at(name);
}

Wish random_wish(World& world, bool may_lie) {
  Wish wish;
  wish.dataset = world.chance(0.3) ? "stored" : world.chance(0.2) ? "gyroid" : "fake";
  wish.request.isovalue = wish.dataset == "fake" ? 1 : (world.chance(0.5) ? 0.1 : 0.4);
  wish.request.error = world.chance(0.5) ? 0.5 : 2;
  wish.request.simplify = world.chance(0.3);
  wish.steps = world.chance(0.8) ? StepPolicy::kProgressive : StepPolicy::kFinalOnly;
  for (const auto& version : versions_of(wish.dataset)) {
    wish.final_digests[version->info().content_id] = final_digest_of(*version, wish.request);
  }
  wish.may_be_damaged = may_lie && wish.dataset == "stored";
  return wish;
}

struct Outcome {
  std::vector<std::string> broken_promises;
  double seconds = 0;  // Simulated.
  std::size_t surfaces = 0;
  std::size_t pauses = 0;
};

Outcome run(std::uint64_t seed) {
  const ThreadLimit one_thread(1);  // Reads of pieces happen in one order.
  Outcome outcome;
  World world(seed);
  const auto report = [&outcome](const std::string& broken) {
    outcome.broken_promises.push_back(broken);
  };
  Weather weather{.cuts = world.chance(0.5) ? world.uniform(0, 0.7) : 0,
                  .lies = world.chance(0.2) ? 0.3 : 0,
                  .slow = world.chance(0.2) ? 0.5 : 0};
  Datasets datasets(world);
  const bool is_replaced = world.chance(0.3);
  SimulatedServer first(world, datasets.store(), 3);
  SimulatedServer second(world, datasets.store(), 2);
  SimulatedGateway gateway(world, {&first, &second}, weather, [&] {
    if (weather.lies == 0 && !is_replaced) report("two servers have answered differently");
  });
  const std::vector<Peer*> peers = {&first, &gateway};

  std::vector<std::shared_ptr<SimulatedClient>> clients;
  const std::size_t count = 1 + world.below(50);
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<Wish> wishes;
    for (std::size_t k = 1 + world.below(2); k > 0; --k) {
      wishes.push_back(random_wish(world, datasets.may_lie()));
    }
    std::unique_ptr<TileFolder> folder;
    if (world.chance(0.1)) {
      folder = std::make_unique<TileFolder>();
      folder->full = world.uniform(0, 1);
    }
    clients.push_back(std::make_shared<SimulatedClient>(world, peers, weather, std::move(wishes),
                                                        std::move(folder), report));
    world.after(world.uniform(0, 20), [client = clients.back()] { client->start(); });
  }
  if (is_replaced) world.after(world.uniform(0, 30), [&] { datasets.replace(); });

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
  outcome.pauses = first.pauses() + second.pauses();
  return outcome;
}

std::uint64_t number_in(const char* variable, std::uint64_t otherwise) {
  const char* const text = std::getenv(variable);
  return text ? parse_number<std::uint64_t>(text).value_or(otherwise) : otherwise;
}

TEST(Simulation, KeepsEveryPromise) {
  set_log_level(LogLevel::kOff);
  const std::uint64_t one = number_in("MULTITETRA_SEED", 0);
  const std::uint64_t seeds = one ? 1 : number_in("MULTITETRA_SEEDS", 100);
  const std::uint64_t start_seed = one ? one : number_in("MULTITETRA_FIRST_SEED", 1);
  const auto start = std::chrono::steady_clock::now();
  double simulated = 0;
  std::size_t surfaces = 0;
  std::size_t pauses = 0;
  for (std::uint64_t i = 0; i < seeds; ++i) {
    const std::uint64_t seed = start_seed + i;
    const Outcome outcome = run(seed);
    simulated += outcome.seconds;
    surfaces += outcome.surfaces;
    pauses += outcome.pauses;
    for (const std::string& broken : outcome.broken_promises) {
      ADD_FAILURE() << "MULTITETRA_SEED=" << seed << ": " << broken;
    }
    if (HasFailure() && !one) break;
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  std::cout << seeds << " seeds, " << surfaces << " surfaces, " << pauses << " pauses, "
            << simulated / 3600 << " simulated hours; "
            << 60 * static_cast<double>(seeds) / seconds.count() << " seeds a minute" << std::endl;
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
