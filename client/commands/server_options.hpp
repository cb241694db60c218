// The options of all commands that name a server, and the access to it.
#pragma once

#include <chrono>
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
  double timeout = 60;  // Seconds without a reply.
  double deadline = 0;  // Seconds for all of it; 0: as long as it takes.
};

// When all of a command that begins now must be over.
[[nodiscard]] std::chrono::steady_clock::time_point deadline_of(const ServerArguments& arguments);

void add_server_options(Command& command, ServerArguments& arguments);

// Parses the arguments. kInvalidArgument with the option's name on failure. Prints a warning when
// the certificate is not verified, or the token is sent unencrypted.
struct ServerAccess {
  Endpoint server;
  ClientOptions options;
};
[[nodiscard]] Result<ServerAccess> access_of(const ServerArguments& arguments);

}  // namespace multitetra
