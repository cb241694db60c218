#include "server/programs/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <utility>

#include "common/base/json.hpp"
#include "common/cli/human_units.hpp"

namespace multitetra {

Progress::Progress(std::string command, std::size_t stages, bool is_quiet, bool prints_stages)
    : command_(std::move(command)),
      expected_(std::max<std::size_t>(stages, 1)),
      is_quiet_(is_quiet),
      is_terminal_(isatty(STDERR_FILENO) == 1),
      prints_stages_(prints_stages && !is_terminal_) {}

Progress::~Progress() {
  if (is_running_ && is_terminal_ && !is_quiet_) clear_line();
}

void Progress::begin(const std::string& stage) {
  end_stage();
  stages_.push_back({stage, 0});
  stage_start_ = last_update_ = Clock::now();
  fraction_ = 0;
  is_running_ = true;
  if (is_terminal_ && !is_quiet_) draw();
}

void Progress::update(double done, double all, const char* unit) {
  using std::chrono::milliseconds;
  const Clock::time_point now = Clock::now();
  const auto pause = is_terminal_ ? milliseconds(100) : milliseconds(10'000);
  if (is_quiet_ || !is_running_ || !(all > 0) || now - last_update_ < pause) return;
  last_update_ = now;
  fraction_ = std::clamp(done / all, 0.0, 1.0);
  const double seconds = std::chrono::duration<double>(now - stage_start_).count();
  const double speed = seconds > 0 ? done / seconds : 0;
  const std::string detail =
      std::to_string(static_cast<int>(100 * fraction_)) + " %, " + human_speed(speed) + " " + unit +
      "/s" + (speed > 0 ? ", " + human_seconds((all - done) / speed) + " left" : "");
  if (is_terminal_) {
    draw(detail);
  } else {
    std::cerr << command_ << ": " << stages_.back().name << " " << detail << std::endl;
  }
}

void Progress::finish() {
  end_stage();
  if (is_quiet_) return;
  if (is_terminal_) clear_line();
  const double total = std::chrono::duration<double>(Clock::now() - start_).count();
  std::cerr << command_ << ": done in " << human_seconds(total) << std::endl;
}

void Progress::print_above_bar(const std::string& sentence) {
  if (is_terminal_ && is_running_ && !is_quiet_) clear_line();
  std::cerr << command_ << ": " << sentence << std::endl;
  if (is_terminal_ && is_running_ && !is_quiet_) draw();
}

Json Progress::seconds() const {
  Json json = Json::object();
  double total = 0;
  for (const Stage& stage : stages_) {
    json[stage.name] = json.value(stage.name, 0.0) + stage.seconds;
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
  if (prints_stages_ && !is_quiet_) {
    std::cerr << command_ << ": " << stage.name << " " << human_seconds(stage.seconds) << std::endl;
  }
}

void Progress::draw(const std::string& detail) const {
  constexpr std::size_t kWidth = 24;
  const double share = (static_cast<double>(stages_.size() - 1) + fraction_) /
                       static_cast<double>(std::max(expected_, stages_.size()));
  const auto filled = static_cast<std::size_t>(kWidth * share);
  std::cerr << "\r\033[K" << command_ << " [" << std::string(filled, '#')
            << std::string(kWidth - filled, '.') << "] " << stages_.size() << "/" << expected_
            << " " << stages_.back().name << (detail.empty() ? "" : ": " + detail) << std::flush;
}

void Progress::clear_line() const { std::cerr << "\r\033[K" << std::flush; }

}  // namespace multitetra
