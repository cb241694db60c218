// Where a session's answers come from: the workers of this process, or other servers. The session
// decides what is answered (session.hpp) and the backend makes it; a session has one of its own.
//
// Everything runs on the executor of the session, of which one thread runs at a time. `changed` and
// `done` are called there as well, never from inside the call that they were given to.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "common/net/net.hpp"
#include "common/wire/messages.hpp"
#include "server/session/session.hpp"

namespace multitetra {

// A stream whose messages are being made. Who drops it calls drop().
class BackendStream {
 public:
  virtual ~BackendStream() = default;

  // The next message, if there is one now. StreamEnd or ErrorReply is the last.
  [[nodiscard]] virtual std::optional<ServerMessage> take() = 0;
  // What was not taken yet is dropped; the last message remains, to be taken at once. The first of
  // these two decides.
  virtual void end(StreamOutcome outcome) = 0;
  virtual void fail(Error error) = 0;
  // Nobody takes any more: what is done for it ends soon.
  virtual void drop() = 0;
};
using BackendStreamPtr = std::shared_ptr<BackendStream>;

class SessionBackend {
 public:
  using Found = Result<CataloguePtr>;

  virtual ~SessionBackend() = default;

  // What the bearer of this token may ask for; nullopt where the session knows from its beginning.
  [[nodiscard]] virtual std::optional<asio::awaitable<Found>> find_catalogue(std::string token) = 0;
  // Begins a stream; the one before was dropped. `changed` tells that there may be another message.
  [[nodiscard]] virtual BackendStreamPtr start(StartStream action,
                                               std::function<void()> changed) = 0;
  // `done` is told once, whatever happens; soon after `stop` is triggered.
  virtual void answer(AnswerQuestion action, std::stop_token stop,
                      std::function<void(Result<QuestionReply>)> done) = 0;
  // What the way to the client was found to carry; streams are planned by it from now on.
  virtual void link_carries(double /*bytes_per_second*/) {}
  // Ends what takes longer than it may.
  virtual void keep_time(std::chrono::steady_clock::time_point now) = 0;
  // The session is over.
  virtual void close() = 0;
};
using SessionBackendPtr = std::shared_ptr<SessionBackend>;

}  // namespace multitetra
