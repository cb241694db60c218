// The implementation of ByteStream. Private to this folder.
//
// Models Asio's AsyncReadStream and AsyncWriteStream, so that asio::async_write and Beast accept a
// StreamSocket& like a tcp::socket&. Not movable, as pending operations refer to it.
//
// As with any socket, at most one read and one write may be in progress, and everything runs on the
// executor of the TCP socket.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>

#include <boost/asio/ssl.hpp>

#include "common/net/net.hpp"
#include "common/net/tls_context.hpp"

namespace multitetra {

class TlsContext : public asio::ssl::context {
 public:
  using asio::ssl::context::context;
};

// A type-erased completion handler that keeps the handler's executor. With it TLS is compiled once
// instead of once per operation.
class IoHandler {
 public:
  using executor_type = asio::any_io_executor;

  enum class HandlerArguments { kError, kErrorAndBytes };
  template <HandlerArguments arguments, typename Handler>
  [[nodiscard]] static IoHandler of(Handler handler, const executor_type& fallback) {
    IoHandler erased;
    erased.executor_ = asio::get_associated_executor(handler, fallback);
    erased.call_ = std::make_unique<CallOf<arguments, Handler>>(std::move(handler));
    return erased;
  }

  [[nodiscard]] executor_type get_executor() const noexcept { return executor_; }
  // Call once.
  void operator()(error_code error, std::size_t bytes = 0) {
    const std::unique_ptr<Call> call = std::move(call_);
    call->run(error, bytes);
  }

 private:
  struct Call {
    virtual ~Call() = default;
    virtual void run(error_code error, std::size_t bytes) = 0;
  };
  template <HandlerArguments arguments, typename Handler>
  struct CallOf final : Call {
    explicit CallOf(Handler&& handler) : handler_(std::move(handler)) {}
    void run(error_code error, std::size_t bytes) override {
      if constexpr (arguments == HandlerArguments::kErrorAndBytes) {
        handler_(error, bytes);
      } else {
        handler_(error);
      }
    }
    Handler handler_;
  };

  IoHandler() = default;

  executor_type executor_;
  std::unique_ptr<Call> call_;
};

// The first buffers of a sequence of any type, which suffice for reading or writing some bytes.
template <typename Buffer>
class FirstBuffers {
 public:
  template <typename Buffers>
  explicit FirstBuffers(const Buffers& all) {
    const auto end = asio::buffer_sequence_end(all);
    for (auto at = asio::buffer_sequence_begin(all); at != end && count_ < buffers_.size(); ++at) {
      buffers_[count_++] = Buffer(*at);
    }
  }
  [[nodiscard]] const Buffer* begin() const { return buffers_.data(); }
  [[nodiscard]] const Buffer* end() const { return buffers_.data() + count_; }

  using value_type = Buffer;
  using const_iterator = const Buffer*;

 private:
  std::array<Buffer, 16> buffers_;
  std::size_t count_ = 0;
};

class StreamSocket {
 public:
  using executor_type = tcp::socket::executor_type;

  // Plain TCP if `tls` is null.
  explicit StreamSocket(tcp::socket socket, TlsContextPtr tls = nullptr)
      : socket_(std::move(socket)), context_(std::move(tls)) {
    if (context_) tls_.emplace(socket_, *context_);
  }
  StreamSocket(const StreamSocket&) = delete;
  StreamSocket& operator=(const StreamSocket&) = delete;

  [[nodiscard]] executor_type get_executor() { return socket_.get_executor(); }
  [[nodiscard]] tcp::socket& socket() { return socket_; }
  [[nodiscard]] bool is_tls() const { return tls_.has_value(); }
  // Returns the OpenSSL object, to set SNI and verification before the handshake. Requires
  // is_tls().
  [[nodiscard]] SSL* native_tls() { return tls_->native_handle(); }

  // Must complete before the first read or write. Does nothing for plain TCP.
  template <typename Token>
  auto async_handshake(asio::ssl::stream_base::handshake_type role, Token&& token) {
    return asio::async_initiate<Token, void(boost::system::error_code)>(
        [this, role](auto handler) {
          handshake(role, erased<HandlerArguments::kError>(std::move(handler)));
        },
        token);
  }

  template <typename Buffers, typename Token>
  auto async_read_some(const Buffers& buffers, Token&& token) {
    return asio::async_initiate<Token, void(boost::system::error_code, std::size_t)>(
        [this](auto handler, const Buffers& into) {
          read_some(FirstBuffers<asio::mutable_buffer>(into),
                    erased<HandlerArguments::kErrorAndBytes>(std::move(handler)));
        },
        token, buffers);
  }

  template <typename Buffers, typename Token>
  auto async_write_some(const Buffers& buffers, Token&& token) {
    return asio::async_initiate<Token, void(boost::system::error_code, std::size_t)>(
        [this](auto handler, const Buffers& from) {
          write_some(FirstBuffers<asio::const_buffer>(from),
                     erased<HandlerArguments::kErrorAndBytes>(std::move(handler)));
        },
        token, buffers);
  }

  // Ends the sending direction with TLS's close_notify or TCP's FIN. With TLS it completes only
  // when the peer does the same, which browsers never do: limit the wait.
  template <typename Token>
  auto async_shutdown(Token&& token) {
    return asio::async_initiate<Token, void(boost::system::error_code)>(
        [this](auto handler) { shut_down(erased<HandlerArguments::kError>(std::move(handler))); },
        token);
  }

  // Pending operations end with an error.
  void close() {
    boost::system::error_code ignored;
    socket_.close(ignored);
  }

 private:
  using HandlerArguments = IoHandler::HandlerArguments;
  template <HandlerArguments arguments, typename Handler>
  [[nodiscard]] IoHandler erased(Handler handler) {
    return IoHandler::of<arguments>(std::move(handler), socket_.get_executor());
  }
  void handshake(asio::ssl::stream_base::handshake_type role, IoHandler handler);
  void read_some(const FirstBuffers<asio::mutable_buffer>& into, IoHandler handler);
  void write_some(const FirstBuffers<asio::const_buffer>& from, IoHandler handler);
  void shut_down(IoHandler handler);
  void succeed(IoHandler handler);

  tcp::socket socket_;
  TlsContextPtr context_;
  std::optional<asio::ssl::stream<tcp::socket&>> tls_;
};

}  // namespace multitetra
