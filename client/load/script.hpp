// The script of a simulated user: a sequence of requests and pauses that depends only on the seed.
// Pure: no clock, no socket.
//
//   Script script(ScriptKind::kDrag, datasets, /*seed=*/7, {});
//   for (;;) play(script.next());
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <random>
#include <string_view>
#include <vector>

#include "common/dataset/dataset_info.hpp"
#include "common/wire/messages.hpp"

namespace multitetra {

enum class ScriptKind {
  kRandomIsovalues,  // A surface, a pause, then another one.
  kDrag,             // The isovalue moves in small steps; each request supersedes the previous one.
  kRegion,           // A coarse surface, then a ball of finer error moving over it.
  kMixed,            // The other kinds in random order.
};
[[nodiscard]] std::optional<ScriptKind> script_kind_from(std::string_view name);
[[nodiscard]] std::string_view name(ScriptKind kind);  // "random-isovalues", "drag", "roi", "mixed"

struct ScriptOptions {
  // The number of different isovalues per dataset, over all users: few are soon cached by the
  // server, many never. At least 1.
  int isovalues = 32;
  std::vector<double> errors = {0.5, 1, 2, 4};  // Voxels; one is chosen at random per surface.
  bool simplify = false;
  std::chrono::milliseconds mean_pause{2'000};  // While a user looks at a surface.
  std::chrono::milliseconds drag_interval{50};  // Between two positions of the slider.
  int drag_length = 20;                         // Slider positions from one end to the other.
};

// A request and what follows it.
struct ScriptedRequest {
  OpenStream open;  // Without the request id and the held tiles.
  // The next request supersedes this one after this time, complete or not. nullopt: it runs to its
  // end.
  std::optional<std::chrono::milliseconds> replaced_after;
  std::chrono::milliseconds pause{0};  // After its end.
};

class Script {
 public:
  // Requires at least one dataset and valid options.
  Script(ScriptKind kind, std::vector<DatasetInfo> datasets, std::uint64_t seed,
         ScriptOptions options);

  [[nodiscard]] ScriptedRequest next();

 private:
  void plan();
  void plan_surface();
  void plan_drag();
  void plan_region();

  // Returns a random number, uniform over 0 <= x < 1.
  double uniform();
  std::size_t random_index(std::size_t count);
  const DatasetInfo& random_dataset() { return datasets_[random_index(datasets_.size())]; }
  double random_error() { return options_.errors[random_index(options_.errors.size())]; }
  std::chrono::milliseconds random_pause();

  ScriptKind kind_;
  std::vector<DatasetInfo> datasets_;
  ScriptOptions options_;
  std::mt19937_64 random_;
  std::deque<ScriptedRequest> planned_;
};

// Returns isovalue `number` of `count`, evenly spaced over a range around the suggested isovalues.
[[nodiscard]] double isovalue(const DatasetInfo& info, int number, int count);

}  // namespace multitetra
