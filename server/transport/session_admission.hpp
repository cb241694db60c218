// A session under the admission control's eyes: what holds before a message reaches it, and how its
// requests are told. For all kinds of sessions.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "server/operations/admission_control.hpp"
#include "server/session/session.hpp"

namespace multitetra {

// What a message from the client brings about. A draining admission lets no new work begin, another
// list of tokens holds at once, and requests beyond the client's rate are answered without the
// session.
[[nodiscard]] Actions receive_from(ClientContext& client, Session& session,
                                   const tl::expected<ClientMessage, ParseError>& message);

[[nodiscard]] RequestFacts facts_of(const char* kind, std::uint64_t id, const std::string& dataset,
                                    const IsosurfaceRequest& request);

}  // namespace multitetra
