// What went wrong with a store of objects.
#pragma once

#include <stdexcept>
#include <string>

namespace multitetra {

// A store that cannot be reached, refuses, or answers what cannot be. The text names the place, the
// problem and a remedy.
class StoreError : public std::runtime_error {
 public:
  // "Cannot read '<place>': <problem>. <remedy>."
  StoreError(const std::string& place, const std::string& problem, const std::string& remedy)
      : std::runtime_error("Cannot read '" + place + "': " + problem + ". " + remedy + ".") {}
};

}  // namespace multitetra
