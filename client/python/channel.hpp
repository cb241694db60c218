// A connection that passes messages on, between a server and another end, such as a page in a
// notebook.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <cstddef>
#include <deque>
#include <memory>
#include <string>
#include <thread>

#include "common/net/async_event.hpp"
#include "common/net/message_channel.hpp"

namespace multitetra {

// Calls `received(bytes)` for each message and `closed(text)` once, in a thread of its own.
// Receives nothing while more than kMostUntaken bytes were received and not taken().
class PythonChannel {
 public:
  PythonChannel(const std::string& url, std::string ca, bool insecure, pybind11::function received,
                pybind11::function closed);
  // Not in the channel's own thread, which it waits for.
  ~PythonChannel();

  [[nodiscard]] bool runs_here() const { return thread_.get_id() == std::this_thread::get_id(); }
  void send(std::string content);
  void taken(std::size_t bytes);
  void close();
  // False when it was closed, or its connection has ended.
  [[nodiscard]] bool is_open() const { return !is_over_; }

 private:
  static constexpr std::size_t kMostUntaken = std::size_t{8} << 20;

  asio::awaitable<void> receive_all();
  asio::awaitable<void> send_all();
  void end(const std::string& reason);

  pybind11::function received_;
  pybind11::function closed_;
  asio::io_context io_{1};
  std::unique_ptr<MessageChannel> channel_;
  AsyncEvent changed_;
  std::atomic<bool> is_over_ = false;
  // In the thread alone:
  std::deque<std::string> outgoing_;
  std::size_t untaken_ = 0;
  std::thread thread_;
};

void define_channel(pybind11::module_& module);

}  // namespace multitetra
