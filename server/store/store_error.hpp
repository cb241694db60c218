// Errors of object stores.
#pragma once

#include <stdexcept>
#include <string>

#include "common/base/address_text.hpp"
#include "common/base/utf8.hpp"

namespace multitetra {

// A store that cannot be reached, denies access, or sends an invalid response. The text names the
// place, the problem and a remedy, in one line without passwords.
class StoreError : public std::runtime_error {
 public:
  // "Cannot read '<place>': <problem>. <remedy>.", or another action.
  StoreError(const std::string& place, const std::string& problem, const std::string& remedy,
             const std::string& action = "read")
      : std::runtime_error(printable("Cannot " + action + " '" + without_password(place) +
                                         "': " + problem + ". " + remedy + ".",
                                     /*keeps_lines=*/false)) {}
};

// A store that denies access to an object (401, 403), which may or may not exist.
class StoreAccessDenied : public StoreError {
 public:
  using StoreError::StoreError;
};

}  // namespace multitetra
