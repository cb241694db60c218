// Shows the progress of a long command: a bar on a terminal, otherwise a line per finished stage,
// or one at the end.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "common/json/json_report.hpp"

namespace multitetra {

// Runs through stages, and records their seconds for the report. Writes to stderr.
class Progress {
 public:
  // `stages` is the total number of stages.
  Progress(std::string command, std::size_t stages, bool is_quiet, bool prints_stages = true);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // Ends the previous stage and begins one; `stage` is a noun such as "errors".
  void begin(const std::string& stage);
  // Reports `done` of `all` units of work in the stage; `unit` is their plural. Prints percentage,
  // speed and remaining time: on a terminal up to ten times a second, otherwise every ten seconds.
  void update(double done, double all, const char* unit);
  void finish();
  // Prints a sentence for the user, above the bar.
  void print_above_bar(const std::string& sentence);

  // Returns stage -> seconds, and "total".
  [[nodiscard]] Json seconds() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Stage {
    std::string name;
    double seconds = 0;
  };
  void draw(const std::string& detail = {}) const;
  void clear_line() const;
  void end_stage();

  std::string command_;
  std::size_t expected_;
  bool is_quiet_;
  bool is_terminal_;
  bool prints_stages_;
  bool is_running_ = false;
  Clock::time_point start_ = Clock::now();
  Clock::time_point stage_start_ = start_;
  Clock::time_point last_update_ = start_;
  // The completed fraction of the current stage.
  double fraction_ = 0;
  std::vector<Stage> stages_;
};

}  // namespace multitetra
