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
  ClientContextPtr client = nullptr;
  std::string request_id = {};
  std::chrono::steady_clock::time_point began = std::chrono::steady_clock::now();
  const char* kind = "malformed";  // As name(Route) has it.
  // The service that answers, for requests that need it.
  CallerPtr caller = nullptr;
  std::stop_source stop{};  // Of work on other threads.
  // What is told of it in the log and counted, and its outcome there; null for what is quick.
  std::unique_ptr<RequestRecord> record = nullptr;
  std::string_view outcome = "complete";
  // For the answer's body, until it has left.
  ByteReservations::Reservation room = {};
  // Called before what may take long: from then on the client is watched for hanging up.
  std::function<void()> watch = {};

  // The answer that tells an error; counted, and the outcome in the log.
  [[nodiscard]] Answer refused(const Error& error);
  // The client is gone: what is done for it ends soon.
  void leave() {
    stop.request_stop();
    if (caller) caller->close();
  }
};

}  // namespace multitetra
