#include "tests/client/transport_listener.hpp"

#include <array>
#include <fstream>
#include <optional>
#include <thread>
#include <vector>

#include <openssl/evp.h>
#include <openssl/sha.h>
#include <boost/asio/read_until.hpp>

#include "common/net/frame.hpp"
#include "common/net/stream_socket.hpp"
#include "tests/support/certificates.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra::testing {
namespace {

// ---- WebSockets without a library, to check the client's library against RFC 6455

enum Opcode : unsigned char { kText = 1, kBinary = 2, kClose = 8, kPing = 9, kPong = 10 };

// Section 4.2.2: the hash of the key followed by a fixed text.
std::string accept_key(const std::string& key) {
  const std::string text = key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";
  std::array<unsigned char, SHA_DIGEST_LENGTH> digest{};
  SHA1(reinterpret_cast<const unsigned char*>(text.data()), text.size(), digest.data());
  std::array<unsigned char, 32> base64{};
  EVP_EncodeBlock(base64.data(), digest.data(), static_cast<int>(digest.size()));
  return reinterpret_cast<const char*>(base64.data());
}

// Returns the value of an HTTP header field; names are case-sensitive.
std::string field_of(const std::string& head, const std::string& name) {
  const std::size_t at = head.find("\r\n" + name + ": ");
  if (at == std::string::npos) return {};
  const std::size_t begin = at + name.size() + 4;
  return head.substr(begin, head.find("\r\n", begin) - begin);
}

// Section 5.2: frames of servers are not masked.
std::string frame_of(Opcode opcode, std::string_view payload, bool is_final = true) {
  std::string frame(1, static_cast<char>((is_final ? 0x80 : 0) | opcode));
  const auto put_size = [&frame, size = payload.size()](int bytes) {
    for (int i = bytes - 1; i >= 0; --i) frame.push_back(static_cast<char>(size >> (8 * i)));
  };
  if (payload.size() < 126) {
    put_size(1);
  } else if (payload.size() < 65536) {
    frame.push_back(126);
    put_size(2);
  } else {
    frame.push_back(127);
    put_size(8);
  }
  return frame.append(payload);
}

struct WebSocketFrame {
  unsigned char opcode = kClose;
  std::string payload;
};

// Reads one masked frame of a client; returns a close frame when the connection ends.
asio::awaitable<WebSocketFrame> next_frame(StreamSocket& socket) {
  error_code error;
  std::array<unsigned char, 8> head{};
  co_await asio::async_read(socket, asio::buffer(head, 2), use_error(error));
  if (error) co_return WebSocketFrame{};
  WebSocketFrame frame{.opcode = static_cast<unsigned char>(head[0] & 15), .payload = {}};
  std::size_t size = head[1] & 127;
  if (size >= 126) {
    const std::size_t bytes = size == 126 ? 2 : 8;
    co_await asio::async_read(socket, asio::buffer(head, bytes), use_error(error));
    size = 0;
    for (std::size_t i = 0; i < bytes; ++i) size = size << 8 | head[i];
  }
  std::array<char, 4> mask{};
  co_await asio::async_read(socket, asio::buffer(mask), use_error(error));
  if (error) co_return WebSocketFrame{};
  frame.payload.resize(size);
  co_await asio::async_read(socket, asio::buffer(frame.payload), use_error(error));
  if (error) co_return WebSocketFrame{};
  for (std::size_t i = 0; i < size; ++i) {
    frame.payload[i] = static_cast<char>(frame.payload[i] ^ mask[i % 4]);
  }
  co_return frame;
}

}  // namespace

class TransportListener::State {
 public:
  State(Transport transport, Endpoint server, ListenerManners manners)
      : transport_(transport), server_(std::move(server)), manners_(std::move(manners)) {
    if (at({}).is_secure()) use_certificate();
    asio::co_spawn(
        io_, [this] { return accept(); }, asio::detached);
    thread_ = std::thread([this] { io_.run(); });
  }
  ~State() {
    io_.stop();
    thread_.join();
  }

  [[nodiscard]] Endpoint at(std::string host) const {
    Endpoint endpoint{.host = std::move(host), .port = port_, .transport = transport_};
    if (endpoint.is_web_socket()) endpoint.path = kStreamPath;
    return endpoint;
  }
  // Accepts only this listener's certificate.
  [[nodiscard]] Trust trust() const {
    return {.ca_file = tls_ ? (folder_.path() / "certificate.pem").string() : ""};
  }

 private:
  struct Passage {
    Passage(tcp::socket socket, const TlsContextPtr& tls, asio::io_context& io)
        : client(std::move(socket), tls), server(io) {}
    void end() {
      client.close();
      error_code ignored;
      server.close(ignored);
    }
    StreamSocket client;
    tcp::socket server;
  };
  using PassagePtr = std::shared_ptr<Passage>;

  void use_certificate() {
    const CertificateAndKey certificate = self_signed(manners_.certificate_names);
    std::ofstream(folder_.path() / "certificate.pem") << certificate.certificate;
    tls_ = std::make_shared<TlsContext>(asio::ssl::context::tls_server);
    tls_->use_certificate_chain(asio::buffer(certificate.certificate));
    tls_->use_private_key(asio::buffer(certificate.key), asio::ssl::context::pem);
  }

  asio::awaitable<void> accept() {
    for (;;) {
      auto passage = std::make_shared<Passage>(co_await acceptor_.async_accept(asio::use_awaitable),
                                               tls_, io_);
      asio::co_spawn(
          io_, [this, passage] { return welcome(passage); }, asio::detached);
    }
  }

  asio::awaitable<void> welcome(PassagePtr passage) {
    error_code error;
    co_await passage->client.async_handshake(asio::ssl::stream_base::server, use_error(error));
    if (error) co_return;
    if (at({}).is_web_socket()) {
      const bool is_open = co_await open_web_socket(passage);
      if (!is_open) co_return;
    }
    const tcp::endpoint server(asio::ip::make_address(server_.host), server_.port);
    co_await passage->server.async_connect(server, use_error(error));
    if (error) co_return;
    asio::co_spawn(
        io_, [this, passage] { return pass_requests(passage); }, asio::detached);
    co_await pass_answers(passage);
  }

  asio::awaitable<void> write(PassagePtr passage, std::string bytes) {
    error_code client_gone;
    co_await asio::async_write(passage->client, asio::buffer(bytes), use_error(client_gone));
  }

  asio::awaitable<bool> open_web_socket(PassagePtr passage) {
    std::string head;
    error_code error;
    co_await asio::async_read_until(passage->client, asio::dynamic_buffer(head), "\r\n\r\n",
                                    use_error(error));
    if (error) co_return false;
    const bool is_right = head.starts_with("GET " + std::string(kStreamPath) + " HTTP/1.1\r\n") &&
                          field_of(head, "Sec-WebSocket-Protocol") == kSubprotocol;
    if (manners_.status != 101 || !is_right) {
      const int status = manners_.status == 101 ? 404 : manners_.status;
      co_await write(passage, "HTTP/1.1 " + std::to_string(status) +
                                  " Refused\r\nContent-Length: 9\r\n\r\nNot here.");
      co_return false;
    }
    std::string answer =
        "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Accept: " +
        accept_key(field_of(head, "Sec-WebSocket-Key")) + "\r\n";
    if (!manners_.subprotocol.empty())
      answer += "Sec-WebSocket-Protocol: " + manners_.subprotocol + "\r\n";
    co_await write(passage, answer + "\r\n");
    co_return true;
  }

  // Returns the next bytes for the server, or an empty string when the client has disconnected.
  asio::awaitable<std::string> next_request(PassagePtr passage) {
    if (!at({}).is_web_socket()) {
      std::array<char, 4096> bytes{};
      error_code error;
      const std::size_t size =
          co_await passage->client.async_read_some(asio::buffer(bytes), use_error(error));
      co_return std::string(bytes.data(), size);
    }
    for (;;) {
      const WebSocketFrame frame = co_await next_frame(passage->client);
      if (frame.opcode == kClose) {
        co_await write(passage, frame_of(kClose, frame.payload));
        co_return std::string();
      }
      if (frame.opcode == kPing) co_await write(passage, frame_of(kPong, frame.payload));
      if (frame.opcode != kBinary) continue;
      co_return frame_header(static_cast<std::uint32_t>(frame.payload.size())) + frame.payload;
    }
  }

  asio::awaitable<void> pass_requests(PassagePtr passage) {
    for (error_code error; !error;) {
      const std::string content = co_await next_request(passage);
      if (content.empty()) break;
      co_await asio::async_write(passage->server, asio::buffer(content), use_error(error));
    }
    passage->end();
  }

  asio::awaitable<void> pass_answers(PassagePtr passage) {
    FrameReader frames(kMaxServerFrameBytes);
    std::vector<char> bytes(64 * 1024);
    const bool is_web_socket = at({}).is_web_socket();
    const Opcode opcode = manners_.text_messages ? kText : kBinary;
    error_code error;
    while (!error) {
      const std::size_t size =
          co_await passage->server.async_read_some(asio::buffer(bytes), use_error(error));
      if (!is_web_socket) {
        co_await write(passage, std::string(bytes.data(), size));
        continue;
      }
      frames.feed({bytes.data(), size});
      for (;;) {
        const auto content = frames.next();
        if (!content || !*content) break;
        co_await write(passage, frame_of(opcode, **content));
      }
    }
    if (is_web_socket && frames.buffered() > 0) {
      const std::size_t size = std::min<std::size_t>(frames.buffered(), 100);
      co_await write(passage, frame_of(opcode, {bytes.data(), size}, /*is_final=*/false));
    }
    passage->end();
  }

  Transport transport_;
  Endpoint server_;
  ListenerManners manners_;
  TemporaryFolder folder_;
  TlsContextPtr tls_;
  asio::io_context io_;
  tcp::acceptor acceptor_{io_, {asio::ip::make_address("127.0.0.1"), 0}};
  std::uint16_t port_ = acceptor_.local_endpoint().port();
  std::thread thread_;
};

TransportListener::TransportListener(Transport transport, Endpoint server, ListenerManners manners)
    : state_(std::make_unique<State>(transport, std::move(server), std::move(manners))) {}
TransportListener::~TransportListener() = default;

Endpoint TransportListener::at(std::string host) const { return state_->at(std::move(host)); }
Trust TransportListener::trust() const { return state_->trust(); }

}  // namespace multitetra::testing
