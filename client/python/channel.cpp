#include "client/python/channel.hpp"

#include <algorithm>
#include <exception>
#include <utility>

#include "common/net/coroutines.hpp"
#include "common/net/trust.hpp"
#include "common/python/raise.hpp"

namespace py = pybind11;
using namespace pybind11::literals;

namespace multitetra {
namespace {

// Calls a function of Python from the thread. What it raises is printed, as nobody catches it.
template <typename Argument>
void call(const py::function& function, const Argument& argument) {
  const py::gil_scoped_acquire held;
  try {
    function(argument());
  } catch (py::error_already_set& problem) {
    problem.discard_as_unraisable("multitetra.Channel");
  }
}

// Deletes a channel, also when a function that it called drops the last reference.
struct ChannelDeleter {
  void operator()(PythonChannel* channel) const {
    if (!channel->runs_here()) return delete channel;
    std::thread([channel] {
      const py::gil_scoped_acquire held;
      delete channel;
    }).detach();
  }
};

}  // namespace

PythonChannel::PythonChannel(const std::string& url, std::string ca, bool insecure,
                             py::function received, py::function closed)
    : received_(std::move(received)), closed_(std::move(closed)), changed_(io_.get_executor()) {
  Endpoint server = argument(parse_server_url(url));
  TlsContextPtr tls = argument(client_tls({.ca_file = std::move(ca), .insecure = insecure}));
  channel_ = std::make_unique<MessageChannel>(io_.get_executor(), std::move(server),
                                              ChannelOptions{.tls = std::move(tls)});
  spawn(
      io_.get_executor(), [this] { return receive_all(); },
      [this](const std::exception_ptr&) { end("The connection has ended."); });
  thread_ = std::thread([this] { io_.run(); });
}

PythonChannel::~PythonChannel() {
  close();
  const py::gil_scoped_release released;
  thread_.join();
}

void PythonChannel::send(std::string content) {
  multitetra::post(io_.get_executor(), [this, content = std::move(content)]() mutable {
    outgoing_.push_back(std::move(content));
    changed_.notify_all();
  });
}

void PythonChannel::taken(std::size_t bytes) {
  multitetra::post(io_.get_executor(), [this, bytes] {
    untaken_ -= std::min(bytes, untaken_);
    changed_.notify_all();
  });
}

void PythonChannel::close() {
  multitetra::post(io_.get_executor(), [this] { end({}); });
}

asio::awaitable<void> PythonChannel::receive_all() {
  if (const auto opened = co_await channel_->open(); !opened) {
    end(opened.error().text);
    co_return;
  }
  spawn(io_.get_executor(), [this] { return send_all(); });
  while (!is_over_) {
    const Result<std::string> message = co_await channel_->receive();
    if (!message) {
      end(message.error().text);
      co_return;
    }
    untaken_ += message->size();
    call(received_, [&] { return py::bytes(*message); });
    while (untaken_ > kMostUntaken && !is_over_) co_await changed_.wait();
  }
}

asio::awaitable<void> PythonChannel::send_all() {
  while (!is_over_) {
    if (outgoing_.empty()) {
      co_await changed_.wait();
      continue;
    }
    std::string content = std::move(outgoing_.front());
    outgoing_.pop_front();
    const auto sent = co_await channel_->send(std::move(content));
    if (!sent) end(sent.error().text);
  }
}

// An empty reason means that the other end wants no more.
void PythonChannel::end(const std::string& reason) {
  if (is_over_.exchange(true)) return;
  channel_->close();
  changed_.notify_all();
  if (!reason.empty()) call(closed_, [&] { return py::str(reason); });
}

void define_channel(py::module_& module) {
  py::class_<PythonChannel, std::unique_ptr<PythonChannel, ChannelDeleter>>(module, "Channel")
      .def(py::init<const std::string&, std::string, bool, py::function, py::function>(), "url"_a,
           "ca"_a, "insecure"_a, "received"_a, "closed"_a)
      .def("send",
           [](PythonChannel& channel, const py::buffer& content) {
             const py::buffer_info bytes = content.request();
             channel.send({static_cast<const char*>(bytes.ptr),
                           static_cast<std::size_t>(bytes.size * bytes.itemsize)});
           })
      .def("taken", &PythonChannel::taken)
      .def_property_readonly("is_open", &PythonChannel::is_open)
      .def("close", &PythonChannel::close);
}

}  // namespace multitetra
