// Interrupts a blocking client from another thread, as a signal does.
#pragma once

#include <chrono>
#include <functional>

namespace multitetra {

// Called during a wait, every kInterruptInterval; true ends the wait. Empty: the wait is not ended.
using Interrupt = std::function<bool()>;
inline constexpr std::chrono::milliseconds kInterruptInterval{100};

}  // namespace multitetra
