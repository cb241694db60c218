// A server with a listener for HTTP on a free port of this machine, running in a thread of its own,
// and clients that speak HTTP and WebSocket to it, blocking.
#pragma once

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include "common/net/websocket.hpp"
#include "common/wire/messages.hpp"
#include "server/http/http_listener.hpp"
#include "server/transport/server.hpp"

namespace multitetra::testing {

class RunningHttpServer {
 public:
  explicit RunningHttpServer(CataloguePtr catalogue, HttpOptions options = {},
                             ServerOptions server = {})
      : server_(std::move(catalogue), on_a_free_port(std::move(server)),
                {[options = on_a_free_port(std::move(options))](const ServerContext& context) {
                  return std::make_unique<HttpListener>(context, options);
                }}),
        thread_([this] { server_.run(); }) {}
  ~RunningHttpServer() { stop(); }
  RunningHttpServer(const RunningHttpServer&) = delete;
  RunningHttpServer& operator=(const RunningHttpServer&) = delete;

  void stop() {
    server_.stop();
    if (thread_.joinable()) thread_.join();
  }
  void drain() { server_.drain(); }
  [[nodiscard]] Endpoint tcp() const { return server_.endpoint(0); }
  [[nodiscard]] Endpoint http() const { return server_.endpoint(1); }

 private:
  template <typename Options>
  static Options on_a_free_port(Options options) {
    spdlog::set_level(spdlog::level::off);
    options.listen = {.host = "127.0.0.1", .port = 0};
    return options;
  }

  Server server_;
  std::thread thread_;
};

// A tokens file: who shows which token may see which datasets.
class TokensFile {
 public:
  struct Line {
    std::string name;
    std::string token;  // Empty: clients without one.
    std::string datasets;
  };
  TokensFile(const std::filesystem::path& folder, const std::vector<Line>& lines)
      : path_(folder / "tokens") {
    std::ofstream file(path_);
    for (const Line& line : lines) {
      file << line.name << ' ';
      if (line.token.empty()) file << "none";
      for (const unsigned char byte : digest_of_token(line.token)) {
        static constexpr const char* kDigits = "0123456789abcdef";
        if (!line.token.empty()) file << kDigits[byte >> 4] << kDigits[byte & 15];
      }
      file << ' ' << line.datasets << '\n';
    }
    file.close();
    std::filesystem::permissions(path_, std::filesystem::perms::owner_read);
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// A connection over which tests say what they like.
class HttpClient {
 public:
  explicit HttpClient(const Endpoint& at) : socket_(io_) {
    socket_.connect({asio::ip::make_address(at.host), at.port});
    socket_.set_option(tcp::no_delay(true));
  }

  void send(std::string_view bytes) { asio::write(socket_, asio::buffer(bytes)); }
  using Response = http::response<http::string_body>;
  // The next answer; `to_head` if it has no body whatever its header says.
  Response receive(bool to_head = false) {
    http::response_parser<http::string_body> parser;
    parser.body_limit(std::uint64_t{1} << 32);
    if (to_head) parser.skip(true);
    http::read(socket_, buffer_, parser);
    return parser.release();
  }
  Response ask(std::string_view method, std::string_view target, std::string_view fields = {}) {
    send(std::string(method) + " " + std::string(target) + " HTTP/1.1\r\nHost: localhost\r\n" +
         std::string(fields) + "\r\n");
    return receive(method == "HEAD");
  }
  Response get(std::string_view target, std::string_view fields = {}) {
    return ask("GET", target, fields);
  }
  // Everything until the server hangs up.
  std::string rest() {
    std::string text;
    boost::system::error_code ended;
    asio::read(socket_, asio::dynamic_buffer(text), ended);
    return text;
  }
  [[nodiscard]] tcp::socket& socket() { return socket_; }

 private:
  asio::io_context io_;
  tcp::socket socket_;
  beast::flat_buffer buffer_;
};

// A conversation over a WebSocket.
class WebSocketClient {
 public:
  explicit WebSocketClient(const Endpoint& at, std::string path = std::string(kStreamPath))
      : socket_(io_) {
    socket_.next_layer().connect({asio::ip::make_address(at.host), at.port});
    socket_.set_option(websocket::stream_base::decorator([](websocket::request_type& request) {
      request.set(http::field::sec_websocket_protocol,
                  beast::string_view(kSubprotocol.data(), kSubprotocol.size()));
    }));
    socket_.handshake(response_, "localhost", path);
    socket_.binary(true);
  }

  void send(const ClientMessage& message) { socket_.write(asio::buffer(serialize(message))); }
  ServerMessage receive() {
    std::string content;
    auto buffer = asio::dynamic_buffer(content);
    socket_.read(buffer);
    return parse_server_message(content).value();
  }
  template <typename M>
  M receive_a() {
    ServerMessage message = receive();
    if (auto* wanted = std::get_if<M>(&message)) return std::move(*wanted);
    ADD_FAILURE() << "another message: alternative " << message.index();
    return {};
  }
  // What closes the WebSocket next.
  websocket::close_reason closed() {
    try {
      for (;;) receive();
    } catch (const boost::system::system_error&) {
      return socket_.reason();
    }
  }
  [[nodiscard]] const websocket::response_type& response() const { return response_; }
  [[nodiscard]] websocket::stream<tcp::socket, false>& socket() { return socket_; }

 private:
  asio::io_context io_;
  websocket::stream<tcp::socket, false> socket_;
  websocket::response_type response_;
};

}  // namespace multitetra::testing
