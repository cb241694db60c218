// Listens for HTTP and WebSockets on one port.
#pragma once

#include <memory>

#include "common/net/byte_stream.hpp"
#include "server/http/http_options.hpp"
#include "server/http/request_handler.hpp"
#include "server/transport/acceptor.hpp"
#include "server/transport/connection_table.hpp"
#include "server/transport/listener.hpp"

namespace multitetra {

class HttpListener : public Listener {
 public:
  // Binds and listens. Throws AddressError, which names the address, if that fails.
  HttpListener(const ServerContext& server, HttpOptions options,
               std::unique_ptr<RequestHandler> handler);

  [[nodiscard]] Endpoint endpoint() const override { return acceptor_.endpoint(); }
  [[nodiscard]] std::string url() const override;
  void open() override;
  void close(const Error& why) override;

 private:
  void accept(tcp::socket socket, const Peer& peer);
  void upgrade(const ConnectionContextPtr& client, std::unique_ptr<ByteStream> stream,
               HttpRequest request);

  ServerContext server_;
  HttpOptions options_;
  std::unique_ptr<RequestHandler> handler_;
  Acceptor acceptor_;
  ConnectionTable connections_;
};

}  // namespace multitetra
