// Lets a caller interrupt a blocking client, as a signal does.
#pragma once

#include <chrono>
#include <functional>

namespace multitetra {

// Called every kInterruptInterval during a wait; returning true ends the wait. Empty: never.
using Interrupt = std::function<bool()>;
inline constexpr std::chrono::milliseconds kInterruptInterval{100};

}  // namespace multitetra
