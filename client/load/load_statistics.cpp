#include "client/load/load_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace multitetra {

double Times::mean() const {
  if (seconds_.empty()) return 0;
  return std::accumulate(seconds_.begin(), seconds_.end(), 0.0) /
         static_cast<double>(seconds_.size());
}

double Times::quantile(double part) const {
  if (seconds_.empty()) return 0;
  std::vector<double> sorted = seconds_;
  const double rank = std::ceil(part * static_cast<double>(sorted.size()));
  const auto place = static_cast<std::size_t>(std::max(rank, 1.0)) - 1;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(place),
                   sorted.end());
  return sorted[place];
}

void LoadStatistics::add_error(const Error& error) {
  Occurrences& of_code = errors[std::string(name(error.code))];
  if (of_code.count++ == 0) of_code.example = error.text;
}

void LoadStatistics::add_failed_check(const std::string& text) {
  ++checks_failed;
  if (failed_checks.size() < kMaxTexts) failed_checks.push_back(text);
}

void LoadStatistics::add(const LoadStatistics& other) {
  using Count = std::uint64_t LoadStatistics::*;
  for (const Count count :
       {&LoadStatistics::streams, &LoadStatistics::complete, &LoadStatistics::replaced,
        &LoadStatistics::failed, &LoadStatistics::unfinished, &LoadStatistics::retried_after_delay,
        &LoadStatistics::steps, &LoadStatistics::tiles, &LoadStatistics::payload_bytes,
        &LoadStatistics::wire_bytes, &LoadStatistics::connections,
        &LoadStatistics::lost_connections, &LoadStatistics::failed_attempts,
        &LoadStatistics::clients_without_connection, &LoadStatistics::thorough_streams,
        &LoadStatistics::tiles_decoded, &LoadStatistics::steps_compared,
        &LoadStatistics::tiles_sent_twice, &LoadStatistics::checks_failed}) {
    this->*count += other.*count;
  }
  seconds = std::max(seconds, other.seconds);
  for (const std::string& text : other.failed_checks) {
    if (failed_checks.size() < kMaxTexts) failed_checks.push_back(text);
  }
  for (const auto& [code, occurrences] : other.errors) {
    Occurrences& of_code = errors[code];
    of_code.count += occurrences.count;
    if (of_code.example.empty()) of_code.example = occurrences.example;
  }
  connect.add(other.connect);
  first_tile.add(other.first_tile);
  first_step.add(other.first_step);
  last_tile.add(other.last_tile);
  whole.add(other.whole);
}

}  // namespace multitetra
