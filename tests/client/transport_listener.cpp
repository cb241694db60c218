#include "tests/client/transport_listener.hpp"

#include <array>
#include <fstream>
#include <optional>
#include <thread>
#include <vector>

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "common/net/frame.hpp"
#include "common/net/stream_socket.hpp"
#include "tests/support/certificates.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {

namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;

// Beast finds these by their arguments.
template <typename Handler>
void async_teardown(beast::role_type, StreamSocket& stream, Handler&& handler) {
  stream.async_shutdown(std::forward<Handler>(handler));
}
inline void beast_close_socket(StreamSocket& stream) { stream.close(); }

namespace testing {

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
  // Which believes this listener and nobody else.
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
    std::optional<websocket::stream<StreamSocket&, false>> messages;
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

  asio::awaitable<bool> open_web_socket(PassagePtr passage) {
    beast::flat_buffer buffer;
    beast::http::request<beast::http::string_body> request;
    error_code error;
    co_await beast::http::async_read(passage->client, buffer, request, use_error(error));
    if (error) co_return false;
    const auto asked = request[beast::http::field::sec_websocket_protocol];
    if (manners_.status != 101 ||
        std::string_view(request.target().data(), request.target().size()) != kStreamPath ||
        std::string_view(asked.data(), asked.size()) != kSubprotocol) {
      beast::http::response<beast::http::string_body> refusal(
          beast::http::int_to_status(
              manners_.status == 101 ? 404U : static_cast<unsigned>(manners_.status)),
          11, "Not here.");
      refusal.prepare_payload();
      co_await beast::http::async_write(passage->client, refusal, use_error(error));
      co_return false;
    }
    passage->messages.emplace(passage->client);
    passage->messages->binary(!manners_.text_messages);
    passage->messages->set_option(
        websocket::stream_base::decorator([this](websocket::response_type& response) {
          if (manners_.subprotocol.empty()) return;
          response.set(beast::http::field::sec_websocket_protocol, manners_.subprotocol);
        }));
    co_await passage->messages->async_accept(request, use_error(error));
    co_return !error;
  }

  asio::awaitable<void> pass_requests(PassagePtr passage) {
    std::array<char, 4096> bytes{};
    for (error_code error; !error;) {
      std::string content;
      if (passage->messages) {
        auto buffer = asio::dynamic_buffer(content);
        const std::size_t size = co_await passage->messages->async_read(buffer, use_error(error));
        content = frame_header(static_cast<std::uint32_t>(size)) + content;
      } else {
        const std::size_t size =
            co_await passage->client.async_read_some(asio::buffer(bytes), use_error(error));
        content.assign(bytes.data(), size);
      }
      if (!error)
        co_await asio::async_write(passage->server, asio::buffer(content), use_error(error));
    }
    passage->end();
  }

  asio::awaitable<void> pass_answers(PassagePtr passage) {
    FrameReader frames(kMaxServerFrameBytes);
    std::vector<char> bytes(64 * 1024);
    error_code error;
    while (!error) {
      const std::size_t size =
          co_await passage->server.async_read_some(asio::buffer(bytes), use_error(error));
      if (!passage->messages) {
        error_code client_gone;
        co_await asio::async_write(passage->client, asio::buffer(bytes, size),
                                   use_error(client_gone));
        continue;
      }
      frames.feed({bytes.data(), size});
      for (;;) {
        const auto content = frames.next();
        if (!content || !*content) break;
        error_code client_gone;
        co_await passage->messages->async_write(asio::buffer(**content), use_error(client_gone));
      }
    }
    if (passage->messages && frames.buffered() > 0) {
      co_await passage->messages->async_write_some(
          false, asio::buffer(bytes, std::min<std::size_t>(frames.buffered(), 100)),
          use_error(error));
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

}  // namespace testing
}  // namespace multitetra
