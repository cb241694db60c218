// Simulated time, links and failures. One seed determines everything that happens.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <utility>

#include "common/net/net.hpp"

namespace multitetra::simulation {

// Runs events in the order of their times, each followed by whatever it made ready on io().
class World {
 public:
  explicit World(std::uint64_t seed) : random_(seed) {}

  [[nodiscard]] double now() const { return now_; }
  [[nodiscard]] asio::io_context& io() { return io_; }
  void after(double seconds, std::function<void()> event) {
    events_.emplace(std::pair(now_ + seconds, ++last_), std::move(event));
  }
  // Runs until `is_over` or no event is left. Returns false if neither is so at time `end`.
  [[nodiscard]] bool run(double end, const std::function<bool()>& is_over) {
    poll();
    while (!events_.empty() && !is_over()) {
      const auto first = events_.begin();
      if (first->first.first > end) return false;
      now_ = first->first.first;
      const std::function<void()> event = std::move(first->second);
      events_.erase(first);
      event();
      poll();
    }
    return true;
  }

  [[nodiscard]] double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() >> 11) * 0x1p-53;
  }
  [[nodiscard]] bool chance(double probability) { return uniform(0, 1) < probability; }
  [[nodiscard]] std::size_t below(std::size_t count) { return random_() % count; }

 private:
  void poll() {
    io_.restart();
    io_.poll();
  }

  std::mt19937_64 random_;
  asio::io_context io_{1};
  double now_ = 0;
  std::uint64_t last_ = 0;  // Events of one time happen in the order of their creation.
  std::map<std::pair<double, std::uint64_t>, std::function<void()>> events_;
};

// What may happen to links.
struct Weather {
  double cuts = 0;  // The probability that a link is cut at some byte.
  double lies = 0;  // That bytes of a link change.
  double slow = 0;  // That a peer may take a hundred bytes a second.
};

// A connection: bytes arrive in pieces of any size, late, and in order, until it is cut.
class Link : public std::enable_shared_from_this<Link> {
 public:
  struct End {
    std::function<void(std::string_view)> received = [](std::string_view) {};
    std::function<void()> closed = [] {};
    std::function<void()> has_room = [] {};
  };
  static constexpr std::size_t kWindow = 1 << 16;  // The bytes that may be under way.

  Link(World& world, const Weather& weather)
      : lies_(world.chance(weather.lies)),
        world_(world),
        latency_(world.uniform(0.001, 0.2)),
        bytes_per_second_(std::pow(10, world.uniform(world.chance(weather.slow) ? 2 : 3.5, 7))),
        cut_after_(world.chance(weather.cuts) ? std::pow(10, world.uniform(1, 5)) : 1e18) {}

  [[nodiscard]] End& end(int side) { return ends_.at(static_cast<std::size_t>(side)); }
  [[nodiscard]] bool is_open() const { return is_open_; }
  [[nodiscard]] bool has_lied() const { return has_lied_; }
  [[nodiscard]] bool has_room(int from) const { return under_way_[from] < kWindow; }
  [[nodiscard]] std::size_t most_under_way() const { return most_under_way_; }

  void send(int from, std::string_view bytes) {
    while (!bytes.empty() && is_open_) {
      const std::size_t size = std::min(bytes.size(), 1 + world_.below(8192));
      std::string piece(bytes.substr(0, size));
      bytes.remove_prefix(size);
      if (lies_ && world_.chance(0.05)) {
        piece[world_.below(size)] ^= static_cast<char>(1 << world_.below(8));
        has_lied_ = true;
      }
      under_way_[from] += size;
      most_under_way_ = std::max(most_under_way_, under_way_[from]);
      double& free_at = free_at_[from];
      free_at = std::max(free_at, world_.now()) + static_cast<double>(size) / bytes_per_second_;
      world_.after(free_at + latency_ - world_.now(),
                   [self = shared_from_this(), from, piece = std::move(piece)] {
                     self->arrive(from, piece);
                   });
    }
  }
  // Both ends learn it after what was sent before has arrived, or at once if the link is cut.
  void close(int from) {
    const double last = std::max(free_at_[from], world_.now()) + latency_;
    world_.after(last - world_.now(), [self = shared_from_this()] { self->cut(); });
  }
  void cut() {
    if (!std::exchange(is_open_, false)) return;
    // The ends refer to their owners, which may refer to this link.
    const std::array<End, 2> ends = std::exchange(ends_, {});
    for (const End& end : ends) end.closed();
  }

 private:
  void arrive(int from, const std::string& piece) {
    if (!is_open_) return;
    under_way_[from] -= piece.size();
    arrived_ += static_cast<double>(piece.size());
    if (arrived_ > cut_after_) return cut();
    const auto received = end(1 - from).received;
    received(piece);
    if (is_open_ && has_room(from)) end(from).has_room();
  }

  const bool lies_;
  World& world_;
  const double latency_;
  const double bytes_per_second_;
  const double cut_after_;
  bool is_open_ = true;
  bool has_lied_ = false;
  double arrived_ = 0;
  std::array<End, 2> ends_;
  std::size_t under_way_[2] = {0, 0};
  std::size_t most_under_way_ = 0;
  double free_at_[2] = {0, 0};
};
using LinkPtr = std::shared_ptr<Link>;

// A program that accepts links, at their end 1.
class Peer {
 public:
  virtual ~Peer() = default;
  virtual void accept(const LinkPtr& link) = 0;
};

}  // namespace multitetra::simulation
