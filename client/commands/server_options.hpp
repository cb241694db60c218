// The options of all commands that connect to a server.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "client/library/client.hpp"
#include "common/cli/command.hpp"

namespace multitetra {

struct ServerArguments {
  std::string server = to_string(Endpoint{.host = "127.0.0.1"});
  std::string token;
  std::string token_file;
  std::string ca_file;
  bool insecure = false;
  double timeout = 60;  // Seconds without progress.
  // Seconds for the whole command; 0: no limit; absent: 600 for every request but streams.
  std::optional<double> deadline;
};

// Returns the deadline of a command that begins now.
[[nodiscard]] std::chrono::steady_clock::time_point deadline_of(const ServerArguments& arguments);

void add_server_options(Command& command, ServerArguments& arguments);

// Parses the arguments. Returns kInvalidArgument with the option's name on failure. Prints a
// warning if the certificate is not verified or the token is sent unencrypted.
struct ServerAccess {
  Endpoint server;
  ClientOptions options;
};
[[nodiscard]] Result<ServerAccess> access_of(const ServerArguments& arguments);

}  // namespace multitetra
