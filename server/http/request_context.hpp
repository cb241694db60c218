// The state of one HTTP request while it is answered.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "server/http/http_response.hpp"
#include "server/operations/admission_control.hpp"
#include "server/service/surface_service.hpp"

namespace multitetra {

struct RequestContext {
  ConnectionContextPtr client = nullptr;
  // Unique in this process. A gateway sends it upstream, so that all logs agree.
  std::uint64_t number = 0;
  // `number` as text.
  std::string request_id = {};
  std::chrono::steady_clock::time_point began = std::chrono::steady_clock::now();
  const char* kind = "malformed";  // Or the name of a resource, or "redirect".
  // The service, for requests that need it.
  ServiceClientPtr service_client = nullptr;
  // The log record; null for quick requests.
  std::unique_ptr<RequestRecord> record = nullptr;
  // The reason of a refusal for the log, if the client gets a different one.
  std::string reason = {};
  // Reserved for the answer's body until it is sent.
  ByteReservations::Reservation reservation = {};
  // Whether the client disconnected before it was answered.
  bool is_disconnected = false;
  // Called before a long operation; afterwards a disconnect of the client is detected.
  std::function<void()> watch = {};

  void take_number(std::uint64_t unique) {
    number = unique;
    request_id = std::to_string(unique);
  }
  // Returns the answer for an error. For a dataset that the token does not cover, only the log
  // names it; the client gets the answer for a missing dataset.
  [[nodiscard]] HttpResponse refused(const Error& error);
  // Cancels the work of a client that has disconnected.
  void on_disconnect() {
    is_disconnected = true;
    if (service_client) service_client->close();
  }
};

}  // namespace multitetra
