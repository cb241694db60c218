#include "server/gateway/upstream_secrets.hpp"

#include <fstream>

#include "common/base/exit_codes.hpp"
#include "common/net/trust.hpp"

namespace multitetra {
namespace {

// Without the line's end that editors and `echo` leave.
std::string first_line_of(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line)) {
    throw ExitError(kNoSecrets, "The token file " + path + " cannot be read, or is empty.");
  }
  while (line.ends_with('\r') || line.ends_with(' ')) line.pop_back();
  return line;
}

}  // namespace

UpstreamSecrets load_upstream_secrets(const UpstreamFiles& files) {
  UpstreamSecrets secrets;
  if (files.needs_tls) {
    auto tls = client_tls({.ca_file = files.ca});
    if (!tls) throw ExitError(kNoSecrets, tls.error().text);
    secrets.tls = *std::move(tls);
  }
  if (!files.token.empty()) secrets.token = first_line_of(files.token);
  return secrets;
}

}  // namespace multitetra
