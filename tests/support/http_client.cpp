#include "tests/support/http_client.hpp"

#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <nlohmann/json.hpp>

namespace multitetra::testing {

namespace http = boost::beast::http;

HttpClient::HttpClient(const Endpoint& at) : socket_(io_) {
  socket_.connect({asio::ip::make_address(at.host), at.port});
  socket_.set_option(tcp::no_delay(true));
}

void HttpClient::send(std::string_view bytes) { asio::write(socket_, asio::buffer(bytes)); }

HttpClient::Response HttpClient::receive(bool to_head) {
  http::response_parser<http::string_body> parser;
  parser.body_limit(std::uint64_t{1} << 32);
  if (to_head) parser.skip(true);
  http::read(socket_, buffer_, parser);
  return parser.release();
}

HttpClient::Response HttpClient::request(std::string_view method, std::string_view target,
                                         std::string_view fields) {
  send(std::string(method) + " " + std::string(target) + " HTTP/1.1\r\nHost: localhost\r\n" +
       std::string(fields) + "\r\n");
  return receive(method == "HEAD");
}

std::string HttpClient::rest() {
  std::string text;
  error_code ended;
  asio::read(socket_, asio::dynamic_buffer(text), ended);
  return text;
}

std::string error_code_of(const HttpClient::Response& response) {
  return nlohmann::json::parse(response.body()).at("error").at("code");
}

}  // namespace multitetra::testing
