#include "server/service/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <utility>

#include "common/human_units.hpp"

namespace multitetra {

Progress::Progress(std::string command, std::size_t stages, bool is_quiet)
    : command_(std::move(command)),
      expected_(std::max<std::size_t>(stages, 1)),
      is_quiet_(is_quiet),
      is_terminal_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (is_running_ && is_terminal_ && !is_quiet_) clear_line();
}

void Progress::begin(const std::string& stage) {
  end_stage();
  stages_.push_back({stage, 0});
  stage_start_ = Clock::now();
  is_running_ = true;
  if (is_terminal_ && !is_quiet_) draw();
}

void Progress::finish() {
  end_stage();
  if (is_quiet_) return;
  if (is_terminal_) clear_line();
  const double total = std::chrono::duration<double>(Clock::now() - start_).count();
  std::cerr << command_ << ": done in " << human_seconds(total) << std::endl;
}

void Progress::note(const std::string& sentence) {
  if (is_terminal_ && is_running_ && !is_quiet_) clear_line();
  std::cerr << command_ << ": " << sentence << std::endl;
  if (is_terminal_ && is_running_ && !is_quiet_) draw();
}

Json Progress::seconds() const {
  Json json = Json::object();
  double total = 0;
  for (const Stage& stage : stages_) {
    json[stage.name] = stage.seconds;
    total += stage.seconds;
  }
  json["total"] = total;
  return json;
}

void Progress::end_stage() {
  if (!is_running_) return;
  is_running_ = false;
  Stage& stage = stages_.back();
  stage.seconds = std::chrono::duration<double>(Clock::now() - stage_start_).count();
  if (!is_terminal_ && !is_quiet_) {
    std::cerr << command_ << ": " << stage.name << " " << human_seconds(stage.seconds) << std::endl;
  }
}

void Progress::draw() const {
  constexpr std::size_t kWidth = 24;
  const std::size_t filled = std::min(kWidth, kWidth * (stages_.size() - 1) / expected_);
  std::cerr << "\r\033[K" << command_ << " [" << std::string(filled, '#')
            << std::string(kWidth - filled, '.') << "] " << stages_.size() << "/" << expected_
            << " " << stages_.back().name << std::flush;
}

void Progress::clear_line() const { std::cerr << "\r\033[K" << std::flush; }

}  // namespace multitetra
