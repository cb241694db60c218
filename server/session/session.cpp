#include "server/session/session.hpp"

#include <algorithm>
#include <utility>

namespace multitetra {
namespace {

Action reply(Error error, std::uint64_t request_id = 0) {
  return Send{ErrorReply{.request_id = request_id, .error = std::move(error)}};
}

// Checks that apply to every stream.
Result<void> check_stream(const OpenStream& open, std::uint64_t last_request_id,
                          std::size_t max_held_digests) {
  if (open.request_id <= last_request_id) {
    return fail(ErrorCode::kInvalidArgument,
                "The request id is " + std::to_string(open.request_id) +
                    "; it must be greater than " + std::to_string(last_request_id) +
                    ", the id of the last stream on this connection.");
  }
  if (open.cached_tile_digests.size() <= max_held_digests) return {};
  return fail(ErrorCode::kLimitExceeded,
              "The request lists " + std::to_string(open.cached_tile_digests.size()) +
                  " held tiles; at most " + std::to_string(max_held_digests) + " are allowed.");
}

std::string version_range(std::uint32_t low, std::uint32_t high) {
  return low == high ? std::to_string(low) : std::to_string(low) + " to " + std::to_string(high);
}

}  // namespace

Session::Session(CataloguePtr catalogue, SessionOptions options, AccessListPtr access,
                 LatestCatalogue latest, RequestLimits limits)
    : catalogue_(std::move(catalogue)),
      latest_(std::move(latest)),
      options_(std::move(options)),
      limits_(limits),
      access_(std::move(access)) {}

Actions Session::renew(AccessListPtr access) {
  access_ = std::move(access);
  if (!is_welcomed_ || is_closed_ || !access_) return {};
  const auto known = client_access_.renew(access_);
  return known ? Actions{} : end(known.error());
}

Actions Session::receive(const ClientMessage& message) {
  if (is_closed_) return {};
  const bool may_be_first =
      std::holds_alternative<Hello>(message) || std::holds_alternative<Ping>(message);
  if (!is_welcomed_ && !may_be_first) {
    return end({ErrorCode::kUnexpectedMessage, "The first message must be Hello."});
  }
  return std::visit([this](const auto& m) { return answer(m); }, message);
}

Actions Session::receive(const ParseError& error) {
  if (is_closed_) return {};
  if (!is_welcomed_ || error.error.code == ErrorCode::kMalformedMessage) return end(error.error);
  return {reply(error.error, error.request_id)};
}

Actions Session::end(const Error& error) {
  if (is_closed_) return {};
  Actions actions;
  if (running_) actions.push_back(StopStream{*running_, error});
  running_.reset();
  is_closed_ = true;
  actions.push_back(reply(error));
  actions.push_back(Close{error.text});
  return actions;
}

void Session::stream_ended(std::uint64_t request_id) {
  if (running_ == request_id) running_.reset();
}

Actions Session::answer(const Hello& hello) {
  if (is_welcomed_) {
    return {reply({ErrorCode::kUnexpectedMessage,
                   "Hello was already received; it must be the first message only."})};
  }
  if (hello.min_version > kProtocolVersion || hello.max_version < kProtocolVersion) {
    return end({ErrorCode::kUnsupportedVersion,
                "The client uses protocol version " +
                    version_range(hello.min_version, hello.max_version) + ", this server version " +
                    std::to_string(kProtocolVersion) + "."});
  }
  if (std::find(hello.codecs.begin(), hello.codecs.end(), PayloadCodec::kDracoLattice) ==
      hello.codecs.end()) {
    return end({ErrorCode::kInvalidArgument,
                "The client does not decode Draco on the lattice (codec 1), which is required."});
  }
  auto client_access = ClientAccess::of(hello.token, access_, catalogue_, limits_);
  if (!client_access) return end(client_access.error());
  client_access_ = *std::move(client_access);
  client_access_.set_codecs(hello.codecs);
  is_welcomed_ = true;
  return {Send{Welcome{.version = kProtocolVersion,
                       .codecs = client_access_.codecs(),
                       .agent = options_.agent,
                       .max_message_bytes = max_message_bytes()}}};
}

Actions Session::answer(const ListDatasets& list) {
  // All pages are of the catalogue of the first.
  if (latest_ && (list.after.empty() || !listed_)) client_access_.offer(listed_ = latest_());
  const PageLimits all{.datasets = kMaxListedDatasets, .bytes = kMaxServerFrameBytes / 2};
  DatasetPage page = client_access_.list(list.after, list.in_pages ? PageLimits{} : all);
  DatasetList reply{.request_id = list.request_id, .next = std::move(page.next)};
  for (const auto* const entry : page.datasets) reply.encoded.push_back(entry->encoded);
  return {Send{std::move(reply)}};
}

// Without a list, requests are about the latest datasets.
void Session::follow_latest() {
  if (latest_ && !listed_) client_access_.offer(latest_());
}

Actions Session::answer(const OpenStream& open) {
  follow_latest();
  if (const auto checked = check_stream(open, last_request_id_, options_.max_held_digests);
      !checked) {
    return {reply(checked.error(), open.request_id)};
  }
  auto accepted = client_access_.accept(open);
  if (!accepted) return {reply(accepted.error(), open.request_id)};
  Actions actions;
  if (running_) actions.push_back(StopStream{*running_, StreamOutcome::kSuperseded});
  last_request_id_ = open.request_id;
  running_ = open.request_id;
  actions.push_back(*std::move(accepted));
  return actions;
}

// A Cancel may cross the end of its stream on the wire, so an unknown id is not an error.
Actions Session::answer(const Cancel& cancel) {
  if (running_ != cancel.request_id) return {};
  running_.reset();
  return {StopStream{cancel.request_id, StreamOutcome::kCancelled}};
}

Actions Session::answer(const Ping& ping) {
  const bool requires_token = !is_welcomed_ && access_ && !access_->rights_of("");
  const bool has_new_list = listed_ && latest_() != listed_;
  return {Send{
      Pong{.value = ping.value, .requires_token = requires_token, .has_new_list = has_new_list}}};
}

Actions Session::answer(const Estimate& estimate) { return accept_query(estimate); }

Actions Session::answer(const Slice& slice) { return accept_query(slice); }

Actions Session::answer(const Probe& probe) { return accept_query(probe); }

Actions Session::accept_query(DatasetQuery query) {
  const std::uint64_t request_id = request_id_of(query);
  follow_latest();
  auto accepted = client_access_.accept(std::move(query));
  if (!accepted) return {reply(accepted.error(), request_id)};
  if (queries_ >= options_.max_queries) {
    return {reply({ErrorCode::kLimitExceeded, "There are " + std::to_string(queries_) +
                                                  " queries (estimates, slices, probes) in "
                                                  "progress on this connection; wait for a reply."},
                  request_id)};
  }
  ++queries_;
  return {*std::move(accepted)};
}

}  // namespace multitetra
