// The local addresses from which simulated clients connect.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/result.hpp"

namespace multitetra {

class SourceAddresses {
 public:
  // The system chooses.
  SourceAddresses() = default;
  // Accepts an IPv4 network, "127.0.1.0/24", without its first and last address, or one address.
  [[nodiscard]] static Result<SourceAddresses> from(std::string_view text);

  [[nodiscard]] std::size_t count() const { return count_; }  // 0: the system chooses.
  // Returns the address of a client, counted from 0; addresses are used in turn.
  [[nodiscard]] std::string of(std::size_t client) const;

 private:
  std::uint32_t first_ = 0;
  std::size_t count_ = 0;
};

}  // namespace multitetra
