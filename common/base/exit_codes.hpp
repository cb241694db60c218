// The exit codes of our programs, which --help lists, and the exceptions with a code of their own.
#pragma once

#include <stdexcept>
#include <string>

namespace multitetra {

enum ExitCode {
  // Done; a server: stopped by request.
  kOk = 0,
  kFailed = 1,  // Failures without a code of their own.
  kUsage = 2,   // Wrong options, in whatever place they stand.
  // For programs that check surfaces:
  kCheckFailed = 3,  // A surface is not what was promised.
  // For servers:
  kNoSecrets = 4,  // Certificate, key or tokens file cannot be used.
  kNoDataset = 5,  // None of the datasets can be served.
  // For programs that write surfaces:
  kEmptySurface = 6,  // The surface has no triangle, and the options do not allow that.
  // For servers:
  kNoAddress = 7,  // An address cannot be listened on, as when another server has it.
};

// An error of the environment (disk, port, files) that ends a program with that code.
class ExitError : public std::runtime_error {
 public:
  ExitError(ExitCode code, const std::string& text) : std::runtime_error(text), code_(code) {}
  [[nodiscard]] ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

class AddressError : public ExitError {
 public:
  explicit AddressError(const std::string& text) : ExitError(kNoAddress, text) {}
};

}  // namespace multitetra
