#include "server/relay/relay_server.hpp"

#include <exception>
#include <utility>

#include "server/gateway/http_door.hpp"
#include "server/operations/log.hpp"
#include "server/relay/relay_dialogue.hpp"

namespace multitetra {

class RelayServer::Running {
 public:
  explicit Running(RelayServerOptions options)
      : options_(std::move(options)), reception_(options_.reception) {
    options_.session.agent = "multitetra-gateway/" MULTITETRA_VERSION;
    options_.relay.secrets = load_upstream_secrets(options_.upstream_files);
    relay_ = std::make_shared<Relay>(reception_.io().get_executor(), options_.relay);
    std::vector<MakeDoor> doors;
    if (options_.tcp) {
      doors.emplace_back(
          [this](const House& house) { return std::make_unique<TcpDoor>(house, *options_.tcp); });
    }
    if (options_.http) {
      doors.emplace_back([this](const House& house) {
        return std::make_unique<HttpDoor>(house, hooked(*options_.http));
      });
    }
    reception_.build({.new_dialogue = [this](GuestPtr guest) { return new_dialogue(guest); },
                      .state = [this] { return state(); },
                      .when_reloaded = [this] { reload_secrets(); },
                      .when_stopping = [this] { relay_->stop(); }},
                     doors);
  }

  [[nodiscard]] Reception& reception() { return reception_; }
  [[nodiscard]] Endpoint tcp() const { return reception_.endpoint(0); }
  [[nodiscard]] Endpoint http() const { return reception_.endpoint(options_.tcp ? 1 : 0); }

  void run() {
    relay_->look_after_upstreams();
    reception_.run();
  }

 private:
  HttpOptions hooked(HttpOptions http) {
    http.hooks.is_ready = [this] { return relay_->is_ready(); };
    http.hooks.find_tile = [this](const ContentDigest& digest) {
      return relay_->tiles().find_plain(digest);
    };
    return http;
  }

  DialoguePtr new_dialogue(GuestPtr guest) {
    return std::make_shared<RelayDialogue>(reception_.io().get_executor(), relay_, options_.session,
                                           std::move(guest), options_.idle_time);
  }

  ServiceState state() {
    const TileCache::Counts counts = relay_->tiles().counts();
    return {.cache_hits = counts.hits,
            .cache_misses = counts.misses,
            .cached_tiles = counts.tiles,
            .cache_bytes = counts.bytes,
            .datasets = relay_->datasets(),
            .upstreams = relay_->upstreams()};
  }

  void reload_secrets() {
    try {
      relay_->use(load_upstream_secrets(options_.upstream_files));
    } catch (const std::exception& trouble) {
      log_line(LogLevel::kError,
               std::string(trouble.what()) + " What servers were shown before stays in use.", {});
    }
  }

  RelayServerOptions options_;
  Reception reception_;
  std::shared_ptr<Relay> relay_;
};

RelayServer::RelayServer(RelayServerOptions options)
    : running_(std::make_unique<Running>(std::move(options))) {}
RelayServer::~RelayServer() = default;

Endpoint RelayServer::http() const { return running_->http(); }
Endpoint RelayServer::tcp() const { return running_->tcp(); }
std::vector<std::string> RelayServer::urls() const { return running_->reception().urls(); }
void RelayServer::run() { running_->run(); }
void RelayServer::stop() { running_->reception().stop(); }
void RelayServer::drain() { running_->reception().drain(); }
void RelayServer::reload() { running_->reception().reload(); }

}  // namespace multitetra
