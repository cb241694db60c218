#include "client/load/load_run.hpp"

#include <sys/resource.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "common/base/parse_number.hpp"
#include "common/base/result.hpp"
#include "common/net/coroutines.hpp"
#include "common/net/net.hpp"

namespace multitetra {
namespace {

std::chrono::milliseconds delay_of(std::size_t client, const LoadOptions& options) {
  return options.ramp * static_cast<std::int64_t>(client) /
         static_cast<std::int64_t>(options.clients + options.idle);
}

// Mixes the seed: unmixed, seeds that differ in one bit would give similar sequences.
std::uint64_t seed_of(std::size_t client, std::uint64_t seed) {
  return seed * 0x9e3779b97f4a7c15U + client;
}

UserOptions with_times(const LoadOptions& options) {
  UserOptions user = options.session;
  user.start = LoadClock::now() + std::chrono::milliseconds(10);
  user.stop = user.start + options.duration;
  user.give_up = user.stop + options.grace;
  return user;
}

// Runs the coroutines client(io, number, counts)() of all clients, divided among threads that each
// have their io and counts. Returns the sum of the counts.
template <typename Counts, typename Client>
Counts on_all_threads(const LoadOptions& options, std::size_t clients, const Client& client) {
  const auto threads = static_cast<std::size_t>(options.threads);
  std::vector<Counts> counts(threads);
  const auto run = [&](std::size_t thread) {
    asio::io_context io(1);
    std::vector<Coroutine> started;  // Live as long as their work.
    for (std::size_t number = thread; number < clients; number += threads) {
      started.push_back(client(io, number, counts[thread]));
      spawn(io.get_executor(), started.back(), [](const std::exception_ptr& failure) {
        if (failure) std::rethrow_exception(failure);
      });
    }
    io.run();
  };
  std::vector<std::thread> others;
  for (std::size_t i = 1; i < threads; ++i) others.emplace_back(run, i);
  run(0);
  for (std::thread& other : others) other.join();
  Counts all;
  for (const Counts& of_thread : counts) all.add(of_thread);
  return all;
}

}  // namespace

Result<SourceAddresses> SourceAddresses::from(std::string_view text) {
  const std::size_t slash = text.find('/');
  const auto bits = slash == std::string_view::npos
                        ? std::optional<std::uint32_t>(32)
                        : parse_number<std::uint32_t>(text.substr(slash + 1));
  error_code error;
  const auto address = asio::ip::make_address_v4(std::string(text.substr(0, slash)), error);
  if (error || !bits || *bits < 8 || *bits > 32) {
    return fail(ErrorCode::kInvalidArgument,
                "\"" + std::string(text) +
                    "\" is not an IPv4 address or network; write for example 127.0.1.0/24.");
  }
  SourceAddresses addresses;
  const std::uint64_t size = std::uint64_t{1} << (32 - *bits);
  const bool has_ends = size > 2;  // The network address and the broadcast address.
  addresses.first_ =
      static_cast<std::uint32_t>(address.to_uint() & ~(size - 1)) + (has_ends ? 1 : 0);
  addresses.count_ = static_cast<std::size_t>(has_ends ? size - 2 : size);
  return addresses;
}

std::string SourceAddresses::of(std::size_t client) const {
  if (count_ == 0) return {};
  return asio::ip::address_v4(first_ + static_cast<std::uint32_t>(client % count_)).to_string();
}

LoadStatistics run_load(const LoadOptions& options) {
  const UserOptions user = with_times(options);
  UserOptions idle = user;
  idle.is_idle = true;
  Agreement agreement;
  return on_all_threads<LoadStatistics>(
      options, options.idle + options.clients,
      [&](asio::io_context& io, std::size_t client, LoadStatistics& statistics) {
        // Idle clients come first, so that they are connected before the others start.
        const auto session = std::make_shared<LoadSession>(
            io, client < options.idle ? idle : user, seed_of(client, options.seed),
            delay_of(client, options), options.from.of(client), statistics, agreement);
        return [session] { return session->run(); };
      });
}

MisbehaviourCounts run_misbehaviour(Misbehaviour kind, const LoadOptions& options) {
  const UserOptions user = with_times(options);
  return on_all_threads<MisbehaviourCounts>(
      options, options.clients,
      [&](asio::io_context&, std::size_t client, MisbehaviourCounts& counts) {
        return [&, client, into = &counts] {
          return misbehave(kind, user, seed_of(client, options.seed), delay_of(client, options),
                           options.from.of(client), *into);
        };
      });
}

Result<void> allow_connections(std::size_t count) {
  constexpr std::size_t kOthers = 64;  // Files, timers and the threads' event loops.
  rlimit limit{};
  ::getrlimit(RLIMIT_NOFILE, &limit);
  const rlim_t needed = count + kOthers;
  if (limit.rlim_cur >= needed) return {};
  if (limit.rlim_max >= needed || limit.rlim_max == RLIM_INFINITY) {
    limit.rlim_cur = needed;
    if (::setrlimit(RLIMIT_NOFILE, &limit) == 0) return {};
  }
  return fail(ErrorCode::kLimitExceeded,
              std::to_string(count) + " clients need " + std::to_string(needed) +
                  " open files, but the limit of this process is " +
                  std::to_string(limit.rlim_max) + "; raise the limit (ulimit -n " +
                  std::to_string(needed) + ", as root) or use fewer clients.");
}

}  // namespace multitetra
