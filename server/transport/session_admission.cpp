#include "server/transport/session_admission.hpp"

#include <optional>
#include <utility>

namespace multitetra {
namespace {

// The id of a message that makes work.
std::optional<std::uint64_t> counted_request(const ClientMessage& message) {
  if (const auto* open = std::get_if<OpenStream>(&message)) return open->request_id;
  if (const auto* estimate = std::get_if<Estimate>(&message)) return estimate->request_id;
  if (const auto* list = std::get_if<ListDatasets>(&message)) return list->request_id;
  return std::nullopt;
}

std::optional<ErrorReply> refusal(ClientContext& client, const Session& session,
                                  const ClientMessage& message) {
  const auto request = counted_request(message);
  if (!request || !session.is_welcomed() || session.is_closed()) return std::nullopt;
  const auto asked = client.may_ask_in_session();
  if (asked) return std::nullopt;
  return ErrorReply{.request_id = *request, .error = asked.error()};
}

void append(Actions& actions, Actions more) {
  for (Action& action : more) actions.push_back(std::move(action));
}

}  // namespace

Actions receive_from(ClientContext& client, Session& session,
                     const tl::expected<ClientMessage, ParseError>& message) {
  const AdmissionControl& admission = client.admission();
  Actions actions;
  if (const auto work = admission.may_begin_work(); !work) session.refuse_work(work.error());
  const bool has_expired = session.rights().has_expired(std::chrono::system_clock::now());
  if (has_expired || session.access() != admission.access()) {
    append(actions, session.renew(admission.access()));
  }
  const bool was_welcomed = session.is_welcomed();
  if (!message) {
    append(actions, session.receive(message.error()));
  } else if (auto refused = refusal(client, session, *message)) {
    actions.push_back(Send{*std::move(refused)});
  } else {
    append(actions, session.receive(*message));
  }
  if (!was_welcomed && session.is_welcomed()) client.is_named(session.rights().name());
  return actions;
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
