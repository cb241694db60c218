// A gateway: continues streams of a lost server at another one, with the product's ForwardedStream.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/net/frame.hpp"
#include "common/wire/messages.hpp"
#include "server/gateway/detail/forwarded_stream.hpp"
#include "tests/simulation/world.hpp"

namespace multitetra::simulation {

inline std::string framed(std::string_view content) {
  return frame_header(static_cast<std::uint32_t>(content.size())) + std::string(content);
}

class SimulatedGateway : public Peer {
 public:
  // Calls `differs` when servers have sent different answers to one request.
  SimulatedGateway(World& world, std::vector<Peer*> upstreams, Weather weather,
                   std::function<void()> differs)
      : world_(world),
        upstreams_(std::move(upstreams)),
        weather_(weather),
        differs_(std::move(differs)) {}

  void accept(const LinkPtr& link) override { std::make_shared<Relay>(*this, link)->start(); }
  [[nodiscard]] std::size_t relays() const { return relays_; }

 private:
  class Relay : public std::enable_shared_from_this<Relay> {
   public:
    Relay(SimulatedGateway& gateway, LinkPtr client)
        : gateway_(gateway), client_(std::move(client)) {
      ++gateway_.relays_;
    }
    ~Relay() { --gateway_.relays_; }
    Relay(const Relay&) = delete;
    Relay& operator=(const Relay&) = delete;

    void start() {
      const auto self = shared_from_this();
      client_->end(1) = {.received = [self](std::string_view b) { self->from_client(b); },
                         .closed = [self] { self->client_left(); },
                         .has_room = [self] { self->forward(); }};
    }

   private:
    void client_left() {
      is_over_ = true;
      if (upstream_) upstream_->cut();
    }
    void leave() {
      is_over_ = true;
      client_->close(1);
      if (upstream_) upstream_->cut();
    }

    void from_client(std::string_view bytes) {
      requests_.feed(bytes);
      for (auto content = requests_.next(); !is_over_; content = requests_.next()) {
        if (!content) return leave();
        if (!*content) return;
        const auto message = parse_client_message(**content);
        if (!message) return leave();
        if (const auto* hello = std::get_if<Hello>(&*message)) hello_ = *hello;
        if (const auto* open = std::get_if<OpenStream>(&*message)) begin(*open);
        if (upstream_ && std::holds_alternative<OpenStream>(*message)) {
          upstream_->send(0, framed(serialize(ClientMessage(stream_->open()))));
        } else if (upstream_) {
          upstream_->send(0, framed(**content));
        } else if (hello_) {
          connect();
        }
      }
    }

    // Names the dataset that the client knows, as ClientAccess does.
    void begin(OpenStream open) {
      if (const auto at = listed_.find(open.dataset); at != listed_.end()) {
        open.content_id = at->second;
      }
      stream_.emplace(std::move(open));
    }

    // Begins with what the client has sent: its Hello, and the stream that is running.
    void connect() {
      if (is_over_) return;
      if (++attempts_ > 40) return leave();
      Peer* const to = gateway_.upstreams_[gateway_.world_.below(gateway_.upstreams_.size())];
      upstream_ = std::make_shared<Link>(gateway_.world_, gateway_.weather_);
      replies_ = FrameReader(kMaxServerFrameBytes);
      is_welcomed_ = false;
      const auto self = shared_from_this();
      upstream_->end(0) = {.received = [self](std::string_view b) { self->from_upstream(b); },
                           .closed = [self] { self->upstream_left(); }};
      to->accept(upstream_);
      upstream_->send(0, framed(serialize(ClientMessage(*hello_))));
      if (!stream_) return;
      stream_->restart();
      upstream_->send(0, framed(serialize(ClientMessage(stream_->open()))));
    }
    void upstream_left() {
      upstream_ = nullptr;
      const bool may_continue = stream_.has_value() || !is_client_welcomed_;
      if (is_over_) return;
      if (!may_continue) return leave();
      gateway_.world_.after(0.5, [self = shared_from_this()] {
        if (!self->upstream_) self->connect();
      });
    }
    void from_upstream(std::string_view bytes) {
      replies_.feed(bytes);
      forward();
    }
    void forward() {
      while (!is_over_ && upstream_ && client_->has_room(1)) {
        auto content = replies_.next();
        if (!content) return leave();
        if (!*content) return;
        const auto message = parse_server_message(**content);
        if (!message) return leave();
        if (!passes(*message)) continue;
        client_->send(1, framed(**content));
      }
    }
    bool passes(const ServerMessage& message) {
      if (std::holds_alternative<Welcome>(message)) {
        is_welcomed_ = true;
        return !std::exchange(is_client_welcomed_, true);
      }
      if (const auto* list = std::get_if<DatasetList>(&message)) {
        for (const DatasetInfo& info : list->datasets) listed_[info.name] = info.content_id;
      }
      const bool is_of_step = std::holds_alternative<StepBegin>(message) ||
                              std::holds_alternative<Tile>(message) ||
                              std::holds_alternative<StepEnd>(message);
      if (stream_ && is_of_step) {
        const auto id = std::visit(
            [](const auto& m) -> std::uint64_t {
              if constexpr (requires { m.request_id; }) return m.request_id;
              return 0;
            },
            message);
        if (id != stream_->open().request_id) return false;  // Of a stream that was superseded.
        const auto verdict = stream_->next(message);
        if (verdict == ForwardedStream::Verdict::kDiffers) {
          gateway_.differs_();
          leave();
        }
        return verdict == ForwardedStream::Verdict::kForward;
      }
      const auto* refusal = std::get_if<ErrorReply>(&message);
      const auto* end = std::get_if<StreamEnd>(&message);
      if (stream_ && ((end && end->request_id == stream_->open().request_id) || refusal)) {
        stream_.reset();
      }
      return true;
    }

    SimulatedGateway& gateway_;
    const LinkPtr client_;
    LinkPtr upstream_;
    FrameReader requests_{kMaxClientFrameBytes};
    FrameReader replies_{kMaxServerFrameBytes};
    std::optional<Hello> hello_;
    std::optional<ForwardedStream> stream_;
    std::map<std::string, std::uint64_t> listed_;  // content_id by name.
    int attempts_ = 0;
    bool is_welcomed_ = false;
    bool is_client_welcomed_ = false;
    bool is_over_ = false;
  };

  World& world_;
  const std::vector<Peer*> upstreams_;
  const Weather weather_;
  const std::function<void()> differs_;
  std::size_t relays_ = 0;
};

}  // namespace multitetra::simulation
