// The exit codes of our programs, as listed by --help, and the exceptions that carry them.
#pragma once

#include <stdexcept>
#include <string>

namespace multitetra {

enum ExitCode {
  // Success; for servers: stopped on request.
  kOk = 0,
  kFailed = 1,  // A failure without a code of its own.
  kUsage = 2,   // Invalid command-line options.
  // For programs that check surfaces:
  kCheckFailed = 3,  // A surface violates its guarantees.
  // For servers:
  kBadCredentials = 4,  // The certificate, key or token file cannot be used.
  kNoDataset = 5,       // None of the datasets can be served.
  // For programs that write surfaces:
  kEmptySurface = 6,  // The surface has no triangle, and the options do not allow that.
  // For servers:
  // Cannot listen on an address, for example because another server uses it.
  kAddressUnavailable = 7,
};

// An error of the environment (disk, port, files) that ends a program with the given code.
class ExitError : public std::runtime_error {
 public:
  ExitError(ExitCode code, const std::string& text) : std::runtime_error(text), code_(code) {}
  [[nodiscard]] ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

class AddressError : public ExitError {
 public:
  explicit AddressError(const std::string& text) : ExitError(kAddressUnavailable, text) {}
};

}  // namespace multitetra
