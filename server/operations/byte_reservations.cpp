#include "server/operations/byte_reservations.hpp"

#include <cmath>

#include "server/operations/client_address.hpp"

namespace multitetra {

std::optional<ByteReservations::Reservation> ByteReservations::take(const std::string& share,
                                                                    std::size_t bytes) {
  if (bytes == 0) return Reservation();
  const std::vector<ShareLevel> levels = share_levels(share);
  std::vector<std::string> names;
  const std::lock_guard lock(accounts_->mutex);
  if (bytes > capacity_ - accounts_->used) return std::nullopt;
  for (const ShareLevel& level : levels) {
    const auto known = accounts_->by_level.find(level.name);
    const std::size_t held = known == accounts_->by_level.end() ? 0 : known->second;
    const std::size_t left_by_others = capacity_ - (accounts_->used - held);
    // The total of several shares, each of which takes its part of what the previous ones leave.
    const double part = 1 - std::pow(1 - part_, level.shares);
    const double limit = part * static_cast<double>(left_by_others);
    if (static_cast<double>(held) + static_cast<double>(bytes) > limit) return std::nullopt;
    names.push_back(level.name);
  }
  for (const std::string& name : names) accounts_->by_level[name] += bytes;
  accounts_->used += bytes;
  return Reservation(accounts_, std::move(names), bytes);
}

ByteReservations::Reservation::~Reservation() {
  if (!accounts_) return;
  const std::lock_guard lock(accounts_->mutex);
  accounts_->used -= bytes_;
  for (const std::string& name : levels_) {
    const auto held = accounts_->by_level.find(name);
    if ((held->second -= bytes_) == 0) accounts_->by_level.erase(held);
  }
}

}  // namespace multitetra
