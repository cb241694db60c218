#include "client/library/client.hpp"

#include "client/library/fetch.hpp"
#include "common/request/shared_budget.hpp"

namespace multitetra {
using Clock = std::chrono::steady_clock;

namespace {

tl::unexpected<ClientError> unexpected_answer(const char* awaited) {
  return fail(ErrorSource::kServer,
              {ErrorCode::kUnexpectedMessage,
               std::string("The server sent an unexpected reply instead of ") + awaited + "."});
}

// Receives the next message, which must be an `Awaited`.
template <typename Awaited>
ClientResult<Awaited> receive(MessageSocket& socket, const char* awaited, Clock::time_point until) {
  auto message = socket.receive(until);
  // A late answer to a Ping of an earlier stream.
  while (message && std::holds_alternative<Pong>(*message)) message = socket.receive(until);
  if (!message) return fail(ErrorSource::kNetwork, message.error());
  if (const auto* refused = std::get_if<ErrorReply>(&*message)) {
    return fail(ErrorSource::kServer, refused->error);
  }
  if (auto* answer = std::get_if<Awaited>(&*message)) return std::move(*answer);
  return unexpected_answer(awaited);
}

tl::unexpected<ClientError> unexpected_page() {
  return fail(ErrorSource::kCheck,
              {ErrorCode::kDamagedData,
               "The server's list of datasets does not end, or its pages are out of order."});
}

// Connects and exchanges Hello and Welcome.
ClientResult<MessageSocket> welcomed_socket(const Endpoint& server, const TlsContextPtr& tls,
                                            const ClientOptions& options) {
  auto socket = MessageSocket::connect(server, options.timeout, {.tls = tls}, options.deadline,
                                       options.interrupt);
  if (!socket) return fail(ErrorSource::kNetwork, socket.error());
  const Hello hello{.min_version = kProtocolVersion,
                    .max_version = kProtocolVersion,
                    .codecs = options.codecs,
                    .token = options.token,
                    .agent = options.agent};
  if (auto sent = socket->send(hello); !sent) return fail(ErrorSource::kNetwork, sent.error());
  const auto welcome = receive<Welcome>(*socket, "Welcome", Clock::now() + options.request_time);
  if (!welcome) return tl::unexpected(welcome.error());
  if (welcome->version != kProtocolVersion) {
    return fail(ErrorSource::kServer,
                {ErrorCode::kUnsupportedVersion,
                 "It uses protocol version " + std::to_string(welcome->version) +
                     "; this client supports version " + std::to_string(kProtocolVersion) + "."});
  }
  return *std::move(socket);
}

}  // namespace

Client::Client(Endpoint server, TlsContextPtr tls, MessageSocket socket, ClientOptions options)
    : server_(std::move(server)),
      tls_(std::move(tls)),
      socket_(std::move(socket)),
      options_(std::move(options)) {}

ClientResult<Client> Client::connect(const Endpoint& server, ClientOptions options) {
  TlsContextPtr tls;
  if (server.is_secure()) {
    auto trusting = client_tls(options.trust);
    if (!trusting) return fail(ErrorSource::kNetwork, trusting.error());
    tls = *std::move(trusting);
  }
  auto socket = welcomed_socket(server, tls, options);
  if (!socket) return tl::unexpected(socket.error());
  return Client(server, std::move(tls), *std::move(socket), std::move(options));
}

ClientResult<void> Client::reconnect() {
  auto socket = welcomed_socket(server_, tls_, options_);
  if (!socket) return tl::unexpected(socket.error());
  socket_ = *std::move(socket);
  return {};
}

ClientResult<std::vector<DatasetInfo>> Client::list_datasets() {
  const Clock::time_point until = request_ends();
  std::vector<DatasetInfo> datasets;
  std::string after;
  do {
    const ListDatasets request{
        .request_id = next_request_id(), .in_pages = true, .after = std::move(after)};
    if (auto sent = send(request); !sent) return tl::unexpected(sent.error());
    auto page = receive<DatasetList>(socket_, "DatasetList", until);
    if (!page) return tl::unexpected(page.error());
    if (!continues_list(*page, datasets)) return unexpected_page();
    datasets.insert(datasets.end(), std::make_move_iterator(page->datasets.begin()),
                    std::make_move_iterator(page->datasets.end()));
    after = std::move(page->next);
  } while (!after.empty());
  return datasets;
}

ClientResult<EstimateReply> Client::estimate(const std::string& dataset,
                                             const IsosurfaceRequest& request) {
  const Estimate query{.request_id = next_request_id(), .dataset = dataset, .request = request};
  if (auto sent = send(query); !sent) return tl::unexpected(sent.error());
  return receive<EstimateReply>(socket_, "EstimateReply", request_ends());
}

ClientResult<void> Client::share_budget(std::span<const std::string> datasets,
                                        std::span<IsosurfaceRequest> requests) {
  if (!needs_shared_budget(requests)) return {};
  std::vector<EstimatedSize> sizes;
  for (std::size_t i = 0; i < requests.size(); ++i) {
    IsosurfaceRequest alone = requests[i];
    alone.max_triangles = alone.max_bytes = 0;
    const auto size = estimate(datasets[i], alone);
    if (!size) return tl::unexpected(size.error());
    sizes.push_back({.triangles = size->triangles, .bytes = size->bytes});
  }
  multitetra::share_budget(requests, sizes);
  return {};
}

ClientResult<SliceReply> Client::slice(const std::string& dataset, const SliceRequest& request) {
  const Slice query{.request_id = next_request_id(), .dataset = dataset, .slice = request};
  if (auto sent = send(query); !sent) return tl::unexpected(sent.error());
  auto reply = receive<SliceReply>(socket_, "SliceReply", request_ends());
  if (reply && (reply->width != request.width || reply->height != request.height)) {
    return fail(ErrorSource::kCheck,
                {ErrorCode::kDamagedData,
                 "The received slice does not have the requested width and height."});
  }
  return reply;
}

ClientResult<ProbeReply> Client::probe(const std::string& dataset, const ProbeRequest& request) {
  const Probe query{.request_id = next_request_id(), .dataset = dataset, .probe = request};
  if (auto sent = send(query); !sent) return tl::unexpected(sent.error());
  auto reply = receive<ProbeReply>(socket_, "ProbeReply", request_ends());
  if (reply && reply->places.size() != request.places.size()) {
    return fail(ErrorSource::kCheck,
                {ErrorCode::kDamagedData, "The reply does not have the requested places."});
  }
  return reply;
}

ClientResult<void> Client::send(const ClientMessage& message) {
  if (auto sent = socket_.send(message); !sent) return fail(ErrorSource::kNetwork, sent.error());
  next_ping_at_ = Clock::now() + options_.timeout / 2;
  return {};
}

ClientResult<std::optional<ServerMessage>> Client::receive_within(
    std::chrono::milliseconds max_wait) {
  const Clock::time_point until = Clock::now() + max_wait;
  for (;;) {
    const auto remaining = std::min(until, next_ping_at_) - Clock::now();
    auto message = socket_.receive_within(std::max(
        std::chrono::ceil<std::chrono::milliseconds>(remaining), std::chrono::milliseconds(0)));
    if (!message) return fail(ErrorSource::kNetwork, message.error());
    if (*message) next_ping_at_ = Clock::now() + options_.timeout / 2;
    if (*message && !std::holds_alternative<Pong>(**message)) return *std::move(message);
    if (Clock::now() >= until) return std::nullopt;
    if (Clock::now() >= next_ping_at_) {
      if (auto sent = send(Ping{}); !sent) return tl::unexpected(sent.error());
      next_ping_at_ = Clock::time_point::max();
    }
  }
}

ClientResult<FetchedStep> Client::fetch(const DatasetInfo& info, OpenStream open,
                                        const std::function<void(const FetchedStep&)>& on_step,
                                        const FetchOptions& options) {
  Fetch fetch(*this, info, std::move(open), options);
  FetchedStep final_step;
  for (;;) {
    auto step = fetch.next();
    if (!step) return tl::unexpected(step.error());
    if (!*step) return final_step;
    final_step = **std::move(step);
    on_step(final_step);
  }
}

}  // namespace multitetra
