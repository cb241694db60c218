#include "client/client.hpp"

namespace multitetra {
namespace {

using Clock = std::chrono::steady_clock;

tl::unexpected<ClientError> trouble(Trouble kind, Error error) {
  return tl::unexpected(ClientError{kind, std::move(error)});
}

tl::unexpected<ClientError> unexpected_answer(const char* awaited) {
  return trouble(Trouble::kServer,
                 {ErrorCode::kUnexpectedMessage,
                  std::string("The server answered with another message than ") + awaited + "."});
}

// The next message, which must be an `Awaited`.
template <typename Awaited>
ClientResult<Awaited> receive(MessageSocket& socket, const char* awaited) {
  auto message = socket.receive();
  if (!message) return trouble(Trouble::kNetwork, message.error());
  if (const auto* refused = std::get_if<ErrorReply>(&*message)) {
    return trouble(Trouble::kServer, refused->error);
  }
  if (auto* answer = std::get_if<Awaited>(&*message)) return std::move(*answer);
  return unexpected_answer(awaited);
}

std::vector<ContentDigest> digests_to_tell(const HeldTiles& held) {
  std::vector<ContentDigest> digests;
  for (const auto& [digest, mesh] : held) {
    if (digests.size() == kMaxHeldDigests) break;
    digests.push_back(digest);
  }
  return digests;
}

}  // namespace

Client::Client(MessageSocket socket, ClientOptions options)
    : socket_(std::move(socket)), options_(std::move(options)) {}

ClientResult<Client> Client::connect(const Endpoint& server, ClientOptions options) {
  auto socket = MessageSocket::connect(server, options.timeout);
  if (!socket) return trouble(Trouble::kNetwork, socket.error());
  const Hello hello{.min_version = kProtocolVersion,
                    .max_version = kProtocolVersion,
                    .codecs = {PayloadCodec::kDracoLattice},
                    .token = options.token,
                    .agent = options.agent};
  if (auto sent = socket->send(hello); !sent) return trouble(Trouble::kNetwork, sent.error());
  const auto welcome = receive<Welcome>(*socket, "Welcome");
  if (!welcome) return tl::unexpected(welcome.error());
  if (welcome->version != kProtocolVersion || welcome->codec != PayloadCodec::kDracoLattice) {
    return trouble(
        Trouble::kServer,
        {ErrorCode::kUnsupportedVersion,
         "It welcomes with protocol version " + std::to_string(welcome->version) + " and codec " +
             std::to_string(static_cast<int>(welcome->codec)) + "; this client asked for version " +
             std::to_string(kProtocolVersion) + " and codec 1."});
  }
  return Client(*std::move(socket), std::move(options));
}

ClientResult<std::vector<DatasetInfo>> Client::list_datasets() {
  if (auto sent = socket_.send(ListDatasets{.request_id = ++last_request_id_}); !sent) {
    return trouble(Trouble::kNetwork, sent.error());
  }
  auto list = receive<DatasetList>(socket_, "DatasetList");
  if (!list) return tl::unexpected(list.error());
  return std::move(list->datasets);
}

ClientResult<FetchedStep> Client::fetch(const DatasetInfo& info, OpenStream open,
                                        const std::function<void(const FetchedStep&)>& on_step,
                                        HeldTiles held) {
  open.request_id = ++last_request_id_;
  open.held = digests_to_tell(held);
  const Clock::time_point start = Clock::now();
  const auto seconds = [start] {
    return std::chrono::duration<double>(Clock::now() - start).count();
  };
  if (auto sent = socket_.send(open); !sent) return trouble(Trouble::kNetwork, sent.error());

  Assembler assembler(info, open, std::move(held), options_.limits);
  FetchedStep current;
  for (;;) {
    const auto message = socket_.receive();
    if (!message) return trouble(Trouble::kNetwork, message.error());
    if (std::holds_alternative<StepBegin>(*message)) current.first_byte_seconds = seconds();
    const auto progress = assembler.receive(*message);
    if (!progress) return trouble(Trouble::kCheck, progress.error());
    if (const auto* step = std::get_if<CommittedStepPtr>(&*progress)) {
      current.step = *step;
      current.seconds = seconds();
      on_step(current);
    } else if (const auto* refusal = std::get_if<Refusal>(&*progress)) {
      return trouble(Trouble::kServer, refusal->error);
    } else if (const auto* end = std::get_if<StreamEnd>(&*progress)) {
      if (end->outcome == StreamOutcome::kComplete) return current;
      return trouble(Trouble::kServer,
                     {ErrorCode::kCancelled, "The server ended the stream before its final step."});
    }
  }
}

}  // namespace multitetra
