// A client of the service as a blocking library.
//
//   auto client = Client::connect({"127.0.0.1", 7410}, {});
//   auto datasets = client->list_datasets();
//   auto fetched = client->fetch(info, open, [](const FetchedStep& step) { ... });
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "client/assembler.hpp"
#include "client/message_socket.hpp"

namespace multitetra {

// Whose trouble it is: the way there, a server that says no, or data that failed a check.
enum class Trouble { kNetwork, kServer, kCheck };

struct ClientError {
  Trouble trouble = Trouble::kNetwork;
  Error error;
};

template <typename T>
using ClientResult = tl::expected<T, ClientError>;

struct ClientOptions {
  std::chrono::milliseconds timeout{60'000};  // Of silence.
  std::string agent = "multitetra-client/" MULTITETRA_VERSION;
  std::string token = {};
  AssemblerLimits limits = {};
};

// A step with what it took to get it. Times count from sending the request.
struct FetchedStep {
  CommittedStepPtr step;
  double first_byte_seconds = 0;  // Until the step's StepBegin.
  double seconds = 0;             // Until the step was complete and checked.
};

class Client {
 public:
  // Connects and says Hello.
  [[nodiscard]] static ClientResult<Client> connect(const Endpoint& server, ClientOptions options);

  [[nodiscard]] ClientResult<std::vector<DatasetInfo>> list_datasets();

  // Runs one stream to its end and calls `on_step` with each step that passed all checks. `open`
  // gets its request id here; `held` is told to the server as far as the protocol allows. Gives the
  // final step.
  [[nodiscard]] ClientResult<FetchedStep> fetch(
      const DatasetInfo& info, OpenStream open,
      const std::function<void(const FetchedStep&)>& on_step, HeldTiles held = {});

 private:
  Client(MessageSocket socket, ClientOptions options);

  MessageSocket socket_;
  ClientOptions options_;
  std::uint64_t last_request_id_ = 0;
};

}  // namespace multitetra
