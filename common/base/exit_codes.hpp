// How our programs end, told by --help, and the troubles that have a code of their own.
#pragma once

#include <stdexcept>
#include <string>

namespace multitetra {

enum ExitCode {
  kOk = 0,      // Done; a server: stopped as it was asked to.
  kFailed = 1,  // What has no code of its own.
  kUsage = 2,   // Wrong options, in whatever place they stand.
  // Of all that check surfaces:
  kCheckFailed = 3,  // A surface is not what was promised.
  // Of servers:
  kNoSecrets = 4,  // Certificate, key or tokens file cannot be used.
  kNoDataset = 5,  // None of the datasets can be served.
  // Of all that write surfaces:
  kEmptySurface = 6,  // There is no triangle, and nobody said that this is fine.
  // Of servers:
  kNoAddress = 7,  // An address cannot be listened on, as when another server has it.
};

// A trouble with the world that ends a program with that code.
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
