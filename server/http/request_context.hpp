// One HTTP request while it is answered.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <string_view>

#include "server/http/answer.hpp"
#include "server/operations/admission_control.hpp"
#include "server/service/surface_service.hpp"

namespace multitetra {

struct RequestContext {
  ConnectionContextPtr client = nullptr;
  std::string request_id = {};
  std::chrono::steady_clock::time_point began = std::chrono::steady_clock::now();
  const char* kind = "malformed";  // As name(Route) has it.
  // The service that answers, for requests that need it.
  CallerPtr caller = nullptr;
  // Stops the request's work on other threads.
  std::stop_source stop{};
  // Its log record and outcome; null for quick requests.
  std::unique_ptr<RequestRecord> record = nullptr;
  std::string_view outcome = "complete";
  // Why it was rejected, for the log; empty where it was not.
  std::string reason = {};
  // For the answer's body, until it has left.
  ByteReservations::Reservation reservation = {};
  // Called before what may take long: from then on the client is watched for hanging up.
  std::function<void()> watch = {};

  // The reply for an error, which is counted and logged. The log names a dataset that the token
  // does not cover; the client gets the reply for one that does not exist.
  [[nodiscard]] Answer refused(const Error& error);
  // Set when the client has disconnected: its work is cancelled.
  void leave() {
    stop.request_stop();
    if (caller) caller->close();
  }
};

}  // namespace multitetra
