// Simulates dragging the isovalue: requests a hundred isovalues from a running server, thirty per
// second, and assembles and checks the steps. Prints how many of them were shown, the time until
// the last one was complete, and the peak memory.
//
//   drag_bench 127.0.0.1:7410 head 300 1500 0.5     isovalues from 300 to 1500, error 0.5
#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <set>
#include <string>

#include "client/library/surface_stream.hpp"
#include "common/net/endpoint.hpp"

namespace multitetra {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr int kIsovalues = 100;
constexpr milliseconds kPeriod{33};

double resident_mebibytes() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    double kibibytes = 0;
    if (word == "VmRSS:" && status >> kibibytes) return kibibytes / 1024;
  }
  return 0;
}

template <typename T>
T value(ClientResult<T> result) {
  if (!result) throw std::runtime_error(result.error().error.text);
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}

int drag(const std::string& server, const std::string& dataset, double from, double to,
         double error) {
  const auto endpoint = parse_endpoint("tcp://" + server);
  if (!endpoint) throw std::runtime_error(endpoint.error().text);
  Client client = value(Client::connect(*endpoint, {}));
  DatasetInfo info;
  for (const DatasetInfo& offered : value(client.list_datasets())) {
    if (offered.name == dataset) info = offered;
  }
  DecodedTileCache tiles({.tiles = 4096, .triangles = 4'000'000});
  SurfaceStream stream(client, tiles);
  std::set<double> shown;
  double first_total = 0;
  for (int i = 0; i < kIsovalues; ++i) {
    const double isovalue = from + (to - from) * i / (kIsovalues - 1);
    const Clock::time_point start = Clock::now();
    value(stream.open(info, {.dataset = dataset,
                             .request = {.isovalue = isovalue, .error = error},
                             .cached_tile_digests = {}}));
    const bool is_last = i + 1 == kIsovalues;
    while (stream.is_running() && (is_last || Clock::now() - start < kPeriod)) {
      const auto left =
          is_last ? milliseconds(1000)
                  : std::chrono::duration_cast<milliseconds>(kPeriod - (Clock::now() - start));
      const StreamUpdate news = value(stream.next(std::max(left, milliseconds(0))));
      const auto* step = std::get_if<FetchedStep>(&news);
      if (step == nullptr) continue;
      const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
      if (shown.insert(isovalue).second) first_total += seconds;
      if (is_last && step->step->begin.is_final) {
        std::printf("the last one complete after %.0f ms\n", 1e3 * seconds);
      }
    }
    if (i % 25 == 24) std::printf("after %d: client %.0f MiB\n", i + 1, resident_mebibytes());
  }
  std::printf("%zu of %d isovalues were shown, on average %.0f ms after the request\n",
              shown.size(), kIsovalues, 1e3 * first_total / static_cast<double>(shown.size()));
  return 0;
}

}  // namespace
}  // namespace multitetra

int main(int argc, char** argv) {
  if (argc != 6) {
    std::cerr << "drag_bench HOST:PORT DATASET FROM TO ERROR\n";
    return 2;
  }
  try {
    return multitetra::drag(argv[1], argv[2], std::atof(argv[3]), std::atof(argv[4]),
                            std::atof(argv[5]));
  } catch (const std::exception& failure) {
    std::cerr << "drag_bench: " << failure.what() << "\n";
    return 1;
  }
}
