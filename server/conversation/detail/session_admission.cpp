#include "server/conversation/detail/session_admission.hpp"

#include <optional>
#include <utility>

#include "server/service/waiting_bytes.hpp"

namespace multitetra {
namespace {

// A message that requests work, and the memory to reserve while it waits.
struct CountedRequest {
  std::uint64_t id = 0;
  std::size_t waiting_bytes = 0;
};
std::optional<CountedRequest> counted_request(const ClientMessage& message) {
  if (const auto* list = std::get_if<ListDatasets>(&message)) {
    return CountedRequest{.id = list->request_id};
  }
  if (const auto* open = std::get_if<OpenStream>(&message)) {
    return CountedRequest{.id = open->request_id, .waiting_bytes = waiting_bytes(*open)};
  }
  std::optional<DatasetQuery> query;
  if (const auto* estimate = std::get_if<Estimate>(&message)) query = *estimate;
  if (const auto* slice = std::get_if<Slice>(&message)) query = *slice;
  if (const auto* probe = std::get_if<Probe>(&message)) query = *probe;
  if (!query) return std::nullopt;
  return CountedRequest{.id = request_id_of(*query), .waiting_bytes = waiting_bytes(*query)};
}

// Checks the rate limit and reserves memory for the request, or returns the error to reply.
tl::expected<ByteReservations::Reservation, ErrorReply> admit(ConnectionContext& client,
                                                              const Session& session,
                                                              const ClientMessage& message,
                                                              std::size_t message_bytes) {
  const auto request = counted_request(message);
  if (!request || !session.is_welcomed() || session.is_closed()) {
    return ByteReservations::Reservation();
  }
  const auto refuse = [&](const Error& why) {
    return tl::unexpected(ErrorReply{.request_id = request->id, .error = why});
  };
  if (const auto within_limit = client.check_rate_limit(message_bytes); !within_limit) {
    return refuse(within_limit.error());
  }
  auto reservation = client.reserve(request->waiting_bytes);
  if (!reservation) return refuse(reservation.error());
  return *std::move(reservation);
}

void append(Actions& actions, Actions more) {
  for (Action& action : more) actions.push_back(std::move(action));
}

}  // namespace

Received receive_from(ConnectionContext& client, Session& session,
                      const tl::expected<ClientMessage, ParseError>& message,
                      std::size_t message_bytes) {
  const AdmissionControl& admission = client.admission();
  Received received;
  Actions& actions = received.actions;
  if (const auto work = admission.check_draining(); !work) session.reject_requests(work.error());
  const bool has_expired =
      session.client_access().rights().has_expired(std::chrono::system_clock::now());
  if (has_expired || session.access() != admission.access()) {
    append(actions, session.renew(admission.access()));
  }
  const bool was_welcomed = session.is_welcomed();
  const auto* const hello = message ? std::get_if<Hello>(&*message) : nullptr;
  if (hello && !was_welcomed && admission.access()) {  // For the line of a refusal.
    client.set_identity(admission.access()->owner_of(hello->token), false);
  }
  if (!message) {
    append(actions, session.receive(message.error()));
  } else if (auto admitted = admit(client, session, *message, message_bytes)) {
    received.reservation = *std::move(admitted);
    append(actions, session.receive(*message));
  } else {
    received.retry_after = admitted.error().error.retry_after;
    actions.push_back(Send{std::move(admitted.error())});
  }
  if (!was_welcomed && session.is_welcomed()) {
    client.set_identity(session.client_access().rights().name(),
                        session.client_access().has_token());
    if (hello) {
      client.set_forwarded_share(hello->on_behalf_of, hello->client_address);
    }
    client.record_welcome();
  }
  return received;
}

RequestFacts facts_of(const DatasetQuery& query) {
  const std::uint64_t id = request_id_of(query);
  if (const IsosurfaceRequest* request = request_of(query)) {
    return facts_of(kind_of(query), id, dataset_of(query), *request);
  }
  RequestFacts facts;
  facts.kind = kind_of(query);
  facts.request = id;
  facts.dataset = dataset_of(query);
  return facts;
}

RequestFacts facts_of(const char* kind, std::uint64_t id, const std::string& dataset,
                      const IsosurfaceRequest& request) {
  return {.kind = kind,
          .request = id,
          .dataset = dataset,
          .isovalue = request.isovalue,
          .error = request.error,
          .unit = name(request.unit)};
}

}  // namespace multitetra
