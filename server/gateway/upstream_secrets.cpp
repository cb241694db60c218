#include "server/gateway/upstream_secrets.hpp"

#include "common/base/exit_codes.hpp"
#include "common/net/trust.hpp"
#include "server/operations/secret_file.hpp"

namespace multitetra {
namespace {

// Strips the line end that editors and `echo` add.
std::string first_line_of(const std::string& path) {
  const std::string content = read_secret_file("token file", path);
  std::string line = content.substr(0, content.find('\n'));
  while (line.ends_with('\r') || line.ends_with(' ')) line.pop_back();
  if (line.empty()) throw ExitError(kBadCredentials, "The token file " + path + " is empty.");
  return line;
}

}  // namespace

UpstreamSecrets load_upstream_secrets(const UpstreamFiles& files) {
  UpstreamSecrets secrets;
  if (files.needs_tls) {
    if (!files.ca.empty()) (void)read_secret_file("certificates file", files.ca);
    auto tls = client_tls({.ca_file = files.ca});
    if (!tls) throw ExitError(kBadCredentials, tls.error().text);
    secrets.tls = *std::move(tls);
  }
  if (!files.token.empty()) secrets.token = first_line_of(files.token);
  return secrets;
}

}  // namespace multitetra
