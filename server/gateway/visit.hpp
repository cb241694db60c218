// One HTTP request while it is answered.
#pragma once

#include <functional>
#include <stop_token>
#include <string>

#include "server/service/dialogue.hpp"

namespace multitetra {

struct Visit {
  std::string peer;
  std::string request_id;
  // The conversation that the answer comes from, while there is one.
  DialoguePtr dialogue = nullptr;
  std::stop_source stop = {};
  // Called before what may take long: from then on the client is watched for hanging up.
  std::function<void()> watch = {};

  // The client is gone: what is done for it ends soon.
  void leave() {
    stop.request_stop();
    if (dialogue) dialogue->leave();
  }
};

}  // namespace multitetra
