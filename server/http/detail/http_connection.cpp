#include "server/http/detail/http_connection.hpp"

#include <algorithm>
#include <atomic>
#include <random>
#include <utility>
#include <vector>

#include "common/net/coroutines.hpp"
#include "server/http/detail/min_transfer_rate.hpp"
#include "server/operations/log.hpp"

namespace multitetra {
namespace {

// The status of requests without an answer in log and metrics, as in nginx.
constexpr int kClientHasLeft = 499;

// Returns an id for answers and the log. The first one is random, to avoid repetition between
// runs; a JSON number holds it exactly.
std::uint64_t new_request_number() {
  constexpr std::uint64_t kMaxSurfaces = 1000;  // The next ones are for surfaces of this request.
  static std::atomic<std::uint64_t> next = (std::uint64_t{std::random_device{}()} << 20) + 1000;
  return next.fetch_add(kMaxSurfaces);
}

}  // namespace

HttpConnection::HttpConnection(std::unique_ptr<ByteStream> stream, ConnectionContextPtr client,
                               std::optional<Error> refusal, RequestHandler& handler,
                               const HttpOptions& options)
    : stream_(std::move(stream)),
      client_(std::move(client)),
      refusal_(std::move(refusal)),
      handler_(handler),
      options_(options),
      requests_(options.max_header_bytes),
      watch_timer_(stream_->executor()) {
  set_socket_options(stream_->socket());
  if (options_.connection.send_buffer_bytes) {
    error_code ignored;
    stream_->socket().set_option(
        asio::socket_base::send_buffer_size(*options_.connection.send_buffer_bytes), ignored);
  }
}

void HttpConnection::start(Upgrade on_upgrade, std::function<void()> on_closed) {
  on_upgrade_ = std::move(on_upgrade);
  on_closed_ = std::move(on_closed);
  allow_idle_eviction(*client_, weak_from_this());
  spawn(
      stream_->executor(), [self = shared_from_this()] { return self->run(); },
      [self = shared_from_this()](const std::exception_ptr& failure) {
        try {
          if (failure) std::rethrow_exception(failure);
          if (self->upgrade_) {
            self->on_upgrade_(std::move(self->stream_), *std::move(self->upgrade_));
            return;
          }
        } catch (const std::exception& error) {
          log_line(LogLevel::kError, std::string("closing the connection: ") + error.what(),
                   {{"peer", self->client_->facts().peer}});
        }
        if (self->stream_) self->stream_->close();
        self->on_closed_();
      });
}

std::optional<Clock::time_point> HttpConnection::idle_since() const {
  return is_answering_ ? std::nullopt : std::optional(idle_since_);
}

void HttpConnection::end(const Error& why) {
  is_ending_ = true;
  if (!is_answering_) {  // Idle, or reading a request that will not be answered.
    stream_->close();
  } else if (context_ && context_->service_client) {
    context_->service_client->close(why);
  } else {
    deadline_.set(options_.connection.linger);
  }
}

void HttpConnection::enforce_limits(Clock::time_point now) {
  if (context_ && context_->service_client) context_->service_client->enforce_limits(now);
  if (!deadline_.is_past(now)) return;
  log_line(LogLevel::kDebug, "closing the connection: it took too long",
           {{"peer", client_->facts().peer}});
  deadline_.clear();
  stream_->close();
}

asio::awaitable<void> HttpConnection::run() {
  deadline_.set(options_.connection.handshake_timeout);
  const error_code error = co_await stream_->handshake_as_server();
  if (error) {
    log_line_about(client_->facts().peer, LogLevel::kInfo, "no TLS: " + error.message(),
                   {{"connection", client_->facts().connection}, {"peer", client_->facts().peer}});
    if (ByteStream::was_plain_http(error)) co_await refuse_plain_http();
    co_return;
  }
  while (auto request = co_await read_request()) {
    is_answering_ = true;
    deadline_.clear();
    const auto context = std::make_shared<RequestContext>();
    context->client = client_;
    context->take_number(new_request_number());
    context->watch = [this] { watch(); };
    const bool with_body = request->method() != http::verb::head;
    // Overload must neither restart the server nor hide it from Prometheus.
    const auto admitted = check_admission(*request);
    if (!admitted && !handler_.is_probe(view_of(request->target()))) {
      context->kind = "refused";
      const HttpResponse response = error_answer(503, admitted.error(), context->request_id);
      co_await write(response, with_body, /*keep_alive=*/false);
      send(&*request, *context, response, with_body, outcome_of(response));
      break;
    }
    context_ = context;
    const HttpResponse response = co_await handler_.answer(*request, *context);
    context_.reset();
    if (response.status == 101) {
      upgrade_ = std::move(request);
      co_return;
    }
    const bool keep_alive = admitted && request->keep_alive() && !is_ending_;
    const bool is_written =
        !context->is_disconnected && co_await write(response, with_body, keep_alive);
    if (context->record && is_written) {
      context->record->sent_body(with_body ? response.body.length : 0);
      context->record->end(outcome_of(response));
    }
    send(&*request, *context, response, with_body, is_written ? outcome_of(response) : "left");
    if (!is_written) co_return;
    if (!keep_alive || is_ending_) break;
    is_answering_ = false;
    idle_since_ = Clock::now();
  }
  co_await close_connection();
}

void HttpConnection::send(const HttpRequest* request, const RequestContext& context,
                          const HttpResponse& response, bool with_body, std::string_view outcome) {
  const std::chrono::duration<double> taken = Clock::now() - context.began;
  const std::string_view reason =
      context.reason.empty() && response.error ? response.error->text : context.reason;
  if (response.error) {
    client_->admission().observer().error_answered(client_->facts(), *response.error, 0);
  }
  constexpr std::size_t kLongestId = 128;
  const std::string_view proxy_id =
      request ? view_of((*request)["X-Request-Id"]).substr(0, kLongestId) : std::string_view();
  const std::string target =
      request ? handler_.loggable(view_of(request->target())) : std::string();
  client_->admission().observer().http_answered(
      client_->facts(), {.id = context.request_id,
                         .proxy_id = proxy_id,
                         .kind = context.kind,
                         .method = request ? view_of(request->method_string()) : std::string_view(),
                         .target = target,
                         .dataset = context.record ? context.record->facts().dataset : "",
                         .status = context.is_disconnected ? kClientHasLeft : response.status,
                         .bytes = with_body ? response.body.length : 0,
                         .seconds = taken.count(),
                         .outcome = outcome,
                         .reason = reason});
}

Result<void> HttpConnection::check_admission(const HttpRequest& request) {
  if (refusal_) return tl::unexpected(*refusal_);
  std::string hops;  // Proxies append to the last line or add one.
  const auto lines = request.equal_range("X-Forwarded-For");
  for (auto line = lines.first; line != lines.second; ++line) {
    if (!hops.empty()) hops += ',';
    hops += view_of(line->value());
  }
  return client_->forwarded_for(hops);
}

asio::awaitable<std::optional<HttpRequest>> HttpConnection::read_request() {
  // The timeout between requests is longer than the one before the first request.
  deadline_.set(std::exchange(had_request_, true) ? options_.keep_alive_timeout
                                                  : options_.connection.handshake_timeout);
  std::array<char, 8 * 1024> buffer;  // NOLINT: it is read into before it is looked at.
  bool is_inside = false;
  for (;;) {
    auto request = requests_.next();
    if (!request) {
      const MalformedRequest& broken = request.error();
      is_answering_ = true;
      RequestContext context;
      context.take_number(new_request_number());
      // Made before it is awaited: GCC 12 destroys an aggregate of an awaiting expression twice.
      const HttpResponse response = error_answer(
          broken.status, {ErrorCode::kMalformedMessage, broken.text}, context.request_id);
      co_await write(response, /*with_body=*/true, /*keep_alive=*/false);
      send(nullptr, context, response, /*with_body=*/true, outcome_of(response));
      co_return std::nullopt;
    }
    if (*request) co_return std::move(**request);
    if (requests_.is_inside() && !std::exchange(is_inside, true)) {
      deadline_.set(options_.connection.handshake_timeout);
    }
    const Transfer came = co_await stream_->read_some(asio::buffer(buffer));
    if (came.error) co_return std::nullopt;
    requests_.feed({buffer.data(), came.bytes});
  }
}

asio::awaitable<bool> HttpConnection::write(const HttpResponse& response, bool with_body,
                                            bool keep_alive) {
  const std::string head = head_of(response, keep_alive);
  const Body& body = response.body;
  const auto* file = std::get_if<SharedFile>(&body.whole);
  std::array<asio::const_buffer, 2> parts = {asio::buffer(head), asio::const_buffer()};
  if (with_body && !file && body.length > 0) {
    const auto* shared = std::get_if<SharedBytes>(&body.whole);
    const std::string& bytes = shared ? **shared : std::get<std::string>(body.whole);
    parts[1] = asio::buffer(bytes.data() + body.first, body.length);
  }
  deadline_.set(options_.connection.write_timeout);
  const Transfer sent = co_await stream_->write(parts[0], parts[1]);
  client_->admission().observer().sent("http", sent.bytes);
  if (sent.error) co_return false;
  if (!with_body || !file) co_return true;
  co_return co_await write_file(**file, body.first, body.length);
}

asio::awaitable<bool> HttpConnection::write_file(const ScratchFile& file, std::uint64_t first,
                                                 std::uint64_t length) {
  std::vector<std::byte> piece(std::min(length, kFilePieceBytes));
  const MinTransferRate slowest(Clock::now(), options_.connection.write_timeout,
                                options_.min_file_bytes_per_second);
  std::uint64_t taken = 0;
  while (length > 0) {
    piece.resize(std::min(length, kFilePieceBytes));
    file.get(first, piece);
    taken += piece.size();
    const Clock::time_point now = Clock::now();
    deadline_.set(slowest.deadline(now, taken) - now);
    const Transfer sent = co_await stream_->write(asio::buffer(piece));
    client_->admission().observer().sent("http", sent.bytes);
    if (sent.error) co_return false;
    first += piece.size();
    length -= piece.size();
  }
  co_return true;
}

void HttpConnection::watch() {
  if (std::exchange(is_watching_, true)) return;
  stream_->socket().async_wait(tcp::socket::wait_read,
                               [self = shared_from_this()](error_code) { self->watch_unread(); });
}

// What can be read is the end of the connection, or bytes that hide it: the next request, or TLS's
// close_notify.
void HttpConnection::watch_unread() {
  constexpr auto kPause = std::chrono::milliseconds(100);
  const bool is_ended = context_ && stream_->is_ended_by_peer();
  if (is_ended) context_->on_disconnect();
  is_watching_ = context_ && !is_ended;
  if (!is_watching_) return;
  watch_timer_.expires_after(kPause);
  watch_timer_.async_wait([self = shared_from_this()](error_code) { self->watch_unread(); });
}

// Reads and drops remaining input for a while: closing with unread bytes would reset the
// connection, and the client could lose the response.
asio::awaitable<void> HttpConnection::close_connection() {
  deadline_.set(options_.connection.linger);
  const error_code error = co_await stream_->shut_down();
  if (stream_->is_tls() && !error) co_return;  // Both sides have closed the stream.
  co_await drain();
}

// Bypasses TLS, whose handshake has failed.
asio::awaitable<void> HttpConnection::refuse_plain_http() {
  deadline_.set(options_.connection.linger);
  constexpr std::string_view kWords =
      "This port uses TLS: write https:// instead of http://, and wss:// instead of ws://.\n";
  const std::string response =
      "HTTP/1.1 400 Bad Request\r\nContent-Type: text/plain\r\nConnection: close\r\n"
      "Content-Length: " +
      std::to_string(kWords.size()) + "\r\n\r\n" + std::string(kWords);
  error_code error;
  co_await asio::async_write(stream_->socket(), asio::buffer(response), use_error(error));
  if (error) co_return;
  stream_->socket().shutdown(tcp::socket::shutdown_send, error);
  co_await drain();
}

// Reads until the peer closes or the deadline passes; closing earlier may lose the response.
asio::awaitable<void> HttpConnection::drain() {
  error_code error;
  std::array<char, 1024> dropped;  // NOLINT: the content is ignored.
  while (!error) {
    co_await stream_->socket().async_read_some(asio::buffer(dropped), use_error(error));
  }
}

}  // namespace multitetra
