// The script of a simulated user: a sequence of requests with times in between, the same for the
// same seed. Pure: no clock, no socket.
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

#include "common/request/dataset_info.hpp"
#include "common/wire/messages.hpp"

namespace multitetra {

enum class ScriptKind {
  kRandomIsovalues,  // A surface, looked at, then another one.
  kDrag,             // The isovalue moves in small steps, each in place of the one before.
  kRegion,           // A coarse surface, then a ball of finer errors that wanders over it.
  kMixed,            // Any of these, one after the other.
};
[[nodiscard]] std::optional<ScriptKind> script_kind_from(std::string_view name);
[[nodiscard]] std::string_view name(ScriptKind kind);  // "random-isovalues", "drag", "roi", "mixed"

struct ScriptOptions {
  // The number of different isovalues of a dataset, for all users together: few are soon in the
  // server's cache, many never. At least 1.
  int isovalues = 32;
  std::vector<double> errors = {0.5, 1, 2, 4};  // Voxels; one is drawn for each surface.
  bool simplify = false;                        // Whether meshes are simplified.
  std::chrono::milliseconds mean_pause{2'000};  // While a user looks at a surface.
  std::chrono::milliseconds drag_interval{50};  // Between two places of a knob.
  int drag_length = 20;                         // Places of the knob from one end to the other.
};

// A request, and what comes after it.
struct Act {
  OpenStream open;  // Without the request id and the tiles held.
  // The next act comes in its place after so long, whether it is complete or not. None: it runs to
  // its end.
  std::optional<std::chrono::milliseconds> replaced_after;
  std::chrono::milliseconds pause{0};  // After its end.
};

class Script {
 public:
  // Requires at least one dataset and valid options.
  Script(ScriptKind kind, std::vector<DatasetInfo> datasets, std::uint64_t seed,
         ScriptOptions options);

  [[nodiscard]] Act next();

 private:
  void plan();
  void plan_surface();
  void plan_drag();
  void plan_region();

  // Uniform over 0 <= x < 1.
  double uniform();
  std::size_t one_of(std::size_t count);
  const DatasetInfo& any_dataset() { return datasets_[one_of(datasets_.size())]; }
  double any_error() { return options_.errors[one_of(options_.errors.size())]; }
  std::chrono::milliseconds any_pause();

  ScriptKind kind_;
  std::vector<DatasetInfo> datasets_;
  ScriptOptions options_;
  std::mt19937_64 random_;
  std::deque<Act> planned_;
};

// Isovalue `number` of `count` that are worth a look: evenly around the suggested ones.
[[nodiscard]] double isovalue(const DatasetInfo& info, int number, int count);

}  // namespace multitetra
