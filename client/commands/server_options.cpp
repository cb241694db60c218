#include "client/commands/server_options.hpp"

#include <unistd.h>

#include <fstream>
#include <iostream>

#include "common/cli/terminal.hpp"

namespace multitetra {
namespace {

// Reads the first line of the file, without the line end that editors and `echo` add.
Result<std::string> token_in(const std::string& path) {
  std::ifstream file(path);
  std::string token;
  if (!std::getline(file, token)) {
    return fail(ErrorCode::kInvalidArgument,
                "--token-file: cannot read a token from " + path + ".");
  }
  while (token.ends_with('\r') || token.ends_with(' ')) token.pop_back();
  return token;
}

void warn(const std::string& text) {
  std::cerr << styled(Style::kYellow, "WARNING:", STDERR_FILENO) << " " << text << std::endl;
}

}  // namespace

void add_server_options(Command& command, ServerArguments& a) {
  command
      .add_option("--server", a.server,
                  "Address, such as wss://HOST:PORT; also tcp://, tls:// and ws://, or behind a "
                  "proxy wss://HOST/PATH/")
      ->envname("MULTITETRA_SERVER")
      ->type_name("ADDRESS")
      ->capture_default_str();
  command.add_option("--token-file", a.token_file, "File whose first line is the access token")
      ->type_name("FILE");
  command.begin_group("Server");
  command
      .add_option("--token", a.token,
                  "Access token; other users of this machine can read it here, unlike in "
                  "--token-file or the environment")
      ->envname("MULTITETRA_TOKEN");
  command
      .add_option("--ca", a.ca_file,
                  "Trust these authorities (PEM) and no others, for tls:// and wss://")
      ->type_name("FILE");
  command.add_flag("--insecure", a.insecure,
                   "Accept any certificate of the server. For tests only");
  command
      .add_option("--timeout", a.timeout, "Seconds without progress after which a request fails")
      ->within(0.1, 86400.0)
      ->type_name("SECONDS")
      ->capture_default_str();
  command
      .add_option(
          "--deadline", a.deadline,
          "Timeout of the whole command in seconds; 0: none (default: 600 for each request, "
          "none for surfaces while they progress)")
      ->within(0.0, 86400.0)
      ->type_name("SECONDS");
  command.begin_group();
}

std::chrono::steady_clock::time_point deadline_of(const ServerArguments& arguments) {
  using Clock = std::chrono::steady_clock;
  if (arguments.deadline.value_or(0) <= 0) return Clock::time_point::max();
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(
                            std::chrono::duration<double>(*arguments.deadline));
}

Result<ServerAccess> access_of(const ServerArguments& arguments) {
  const auto server = parse_server_url(arguments.server);
  if (!server) return fail(ErrorCode::kInvalidArgument, "--server: " + server.error().text);
  ServerAccess access{
      .server = *server,
      .options = {
          .timeout = std::chrono::milliseconds(static_cast<std::int64_t>(arguments.timeout * 1000)),
          .deadline = deadline_of(arguments),
          .token = arguments.token,
          .trust = {.ca_file = arguments.ca_file, .insecure = arguments.insecure}}};
  if (arguments.deadline) access.options.request_time = std::chrono::hours(24);
  if (!arguments.token_file.empty()) {
    auto token = token_in(arguments.token_file);
    if (!token) return tl::unexpected(token.error());
    access.options.token = *std::move(token);
  }
  if (server->is_secure()) {
    if (const auto tls = client_tls(access.options.trust); !tls) {
      return fail(ErrorCode::kInvalidArgument, "--ca: " + tls.error().text);
    }
    if (arguments.insecure) {
      warn("--insecure: the server's certificate is NOT checked; the server may be an impostor.");
    }
  } else if (!access.options.token.empty() && !is_this_machine(server->host)) {
    warn("the token travels unencrypted to " + to_string(*server) + "; use tls:// or wss://.");
  }
  return access;
}

}  // namespace multitetra
