#include "server/service/server.hpp"

#include <utility>

#include "server/service/reception.hpp"
#include "server/service/workers.hpp"

namespace multitetra {

class Server::Running {
 public:
  Running(CataloguePtr catalogue, ServerOptions options, const std::vector<MakeDoor>& more)
      : catalogue_(std::move(catalogue)),
        options_(std::move(options)),
        reception_({.heed_signals = options_.heed_signals,
                    .drain_time = options_.drain_time,
                    .keeper = options_.keeper,
                    .metrics = options_.metrics}),
        workers_(options_.workers) {
    options_.connection.max_message_bytes = options_.session.max_message_bytes;
    std::vector<MakeDoor> doors;
    if (options_.has_tcp_door) {
      doors.emplace_back([this](const House& house) {
        return std::make_unique<TcpDoor>(
            house, TcpDoorOptions{.listen = options_.listen, .connection = options_.connection});
      });
    }
    doors.insert(doors.end(), more.begin(), more.end());
    reception_.build(
        {.new_dialogue = [this](GuestPtr guest) { return new_dialogue(std::move(guest)); },
         .state = [this] { return state(); }},
        doors);
  }
  ~Running() { workers_.join(); }

  [[nodiscard]] Reception& reception() { return reception_; }

  void run() {
    reception_.run();
    workers_.join();
  }

 private:
  DialoguePtr new_dialogue(GuestPtr guest) {
    return std::make_shared<Conversation>(
        reception_.io().get_executor(), workers_,
        Session(catalogue_, options_.session, reception_.keeper().access()), std::move(guest),
        options_.limits);
  }

  ServiceState state() {
    ServiceState state = options_.state ? options_.state() : ServiceState{};
    state.waiting_jobs = workers_.waiting();
    state.datasets = catalogue_->size();
    return state;
  }

  CataloguePtr catalogue_;
  ServerOptions options_;
  Reception reception_;
  Workers workers_;  // They end before what their jobs come back to.
};

Server::Server(CataloguePtr catalogue, ServerOptions options, const std::vector<MakeDoor>& more)
    : running_(std::make_unique<Running>(std::move(catalogue), std::move(options), more)) {}
Server::~Server() = default;

Endpoint Server::endpoint(std::size_t door) const { return running_->reception().endpoint(door); }
std::vector<std::string> Server::urls() const { return running_->reception().urls(); }
void Server::run() { running_->run(); }
void Server::stop() { running_->reception().stop(); }
void Server::drain() { running_->reception().drain(); }
void Server::reload() { running_->reception().reload(); }

}  // namespace multitetra
