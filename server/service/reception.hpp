// The doors of a server, who keeps them, and how it ends: what a server that makes surfaces and a
// relay in front of others have in common.
//
//   Reception reception({.keeper = ...});
//   reception.build({.new_dialogue = ...}, {make_tcp_door, make_http_door});
//   reception.run();  // Until stop() or drain() is called from another thread, or a signal comes.
//
// One thread, the caller of run(), does all input and output.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/operations/doorkeeper.hpp"
#include "server/operations/prometheus_metrics.hpp"
#include "server/service/door.hpp"

namespace multitetra {

struct ReceptionOptions {
  // SIGINT and SIGTERM drain, a second one stops at once; SIGHUP reloads.
  bool heed_signals = false;
  std::chrono::milliseconds drain_time{30'000};  // For requests that run when it drains.
  DoorkeeperOptions keeper = {};
  // Kept, and given to whoever asks at a door. Null: none are.
  std::shared_ptr<PrometheusMetrics> metrics = {};
};

// What the doors lead into. Called on the thread of run().
struct BehindDoors {
  std::function<DialoguePtr(GuestPtr guest)> new_dialogue;
  std::function<ServiceState()> state = {};  // For the metrics, beside what the doors know.
  std::function<void()> when_reloaded = {};
  std::function<void()> when_stopping = {};
};

class Reception {
 public:
  // Throws ExitError when certificate or tokens cannot be used.
  explicit Reception(ReceptionOptions options);
  ~Reception();

  [[nodiscard]] asio::io_context& io();
  [[nodiscard]] Doorkeeper& keeper();

  // All doors are bound and listen. Once, before run(). Throws AddressError that names the address
  // when that fails.
  void build(BehindDoors behind, const std::vector<MakeDoor>& doors);
  // Of the doors in their order.
  [[nodiscard]] Endpoint endpoint(std::size_t door) const;
  [[nodiscard]] std::vector<std::string> urls() const;

  // Serves until stopped. Returns when all connections are closed and nothing is left to do.
  void run();
  // From any thread. Clients are told; after the linger time connections are closed.
  void stop();
  // From any thread. Nothing new is begun; stops when no request is under way any more, or the
  // drain time is over.
  void drain();
  // From any thread. Reads certificate and tokens again (see doorkeeper.hpp).
  void reload();

 private:
  class Running;
  std::unique_ptr<Running> running_;
};

}  // namespace multitetra
