// A client that requests surfaces one after the other, with the product's assembler and tile cache,
// and checks the promises that it is given.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "client/library/assembler.hpp"
#include "client/library/decoded_tile_cache.hpp"
#include "client/library/tile_disk_cache.hpp"
#include "common/net/frame.hpp"
#include "tests/simulation/simulated_disk.hpp"
#include "tests/simulation/simulated_gateway.hpp"
#include "tests/simulation/world.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra::simulation {

// What a client requests, and the digest of the final step that any server must send, by the
// content_id of the dataset.
struct Wish {
  std::string dataset;
  IsosurfaceRequest request;
  StepPolicy steps = StepPolicy::kProgressive;
  std::map<std::uint64_t, ContentDigest> final_digests;
  bool may_be_damaged = false;  // Reads of the dataset may lie twice.
};

// The folder in which a client keeps its tiles, on a disk that is full from time to time.
struct TileFolder {
  TemporaryFolder folder;
  TileDiskCache tiles{folder.path()};
  double full = 0;  // The probability that a write fails.
};

class SimulatedClient : public std::enable_shared_from_this<SimulatedClient> {
 public:
  using Report = std::function<void(const std::string& broken_promise)>;

  SimulatedClient(World& world, std::vector<Peer*> peers, Weather weather, std::vector<Wish> wishes,
                  std::unique_ptr<TileFolder> folder, Report report)
      : world_(world),
        peers_(std::move(peers)),
        weather_(weather),
        wishes_(std::move(wishes)),
        folder_(std::move(folder)),
        report_(std::move(report)) {}

  void start() { connect(); }
  [[nodiscard]] bool is_done() const { return is_done_; }
  [[nodiscard]] std::size_t surfaces() const { return surfaces_; }
  void leave() {
    if (link_) link_->cut();
  }

 private:
  // ---- the connection

  void connect() {
    if (is_done_) return;
    if (++attempts_ > 200) {
      report_("a client could not be served in 200 attempts");
      return finish();
    }
    link_ = std::make_shared<Link>(world_, weather_);
    reader_ = FrameReader(kMaxServerFrameBytes);
    const std::uint64_t link = ++link_number_;
    const auto self = shared_from_this();
    link_->end(0) = {.received =
                         [self, link](std::string_view b) {
                           if (link == self->link_number_) self->feed(b);
                         },
                     .closed = [self, link] { self->lost(link); }};
    peers_[world_.below(peers_.size())]->accept(link_);
    last_request_id_ = 0;
    send(Hello{.min_version = kProtocolVersion, .max_version = kProtocolVersion, .token = {}});
    watch(link);
  }
  // A server may be silent while it computes, but not for ever.
  void watch(std::uint64_t link) {
    heard_ = false;
    world_.after(120, [self = shared_from_this(), link] {
      if (self->is_done_ || link != self->link_number_) return;
      self->heard_ ? self->watch(link) : self->link_->cut();
    });
  }
  void lost(std::uint64_t link) {
    if (is_done_ || link != link_number_) return;
    ++link_number_;
    keep_decoded();
    // Some start again, with what is in their folders.
    if (folder_ && world_.chance(0.5)) {
      tiles_ = DecodedTileCache();
      folder_->tiles.load(tiles_, AssemblerLimits().triangles);
      open_.reset();
    }
    world_.after(world_.uniform(0.1, 2), [self = shared_from_this()] { self->connect(); });
  }
  void send(const ClientMessage& message) { link_->send(0, framed(serialize(message))); }
  void feed(std::string_view bytes) {
    heard_ = true;
    reader_.feed(bytes);
    const std::uint64_t link = link_number_;
    while (!is_done_ && link == link_number_ && link_->is_open()) {
      const auto content = reader_.next();
      if (!content) return broken("the framing: " + content.error().text);
      if (!*content) return;
      const auto message = parse_server_message(**content);
      if (!message) return broken("a message: " + message.error().error.text);
      receive(*message);
    }
  }
  // Only links that lie may cause this.
  void broken(const std::string& what) {
    if (weather_.lies == 0) report_("an honest server sent what fails a check, " + what);
    assembler_.reset();
    link_->cut();
  }

  // ---- the conversation

  void receive(const ServerMessage& message) {
    if (std::holds_alternative<Welcome>(message)) {
      list();
    } else if (const auto* list = std::get_if<DatasetList>(&message)) {
      listed(*list);
    } else if (const auto* error = std::get_if<ErrorReply>(&message); error && !error->request_id) {
      link_->cut();
    } else if (assembler_) {
      assemble(message);
    }
  }
  void list(const std::string& after = {}) {
    send(ListDatasets{.request_id = 1, .in_pages = true, .after = after});
  }
  void listed(const DatasetList& page) {
    if (!continues_list(page, listed_)) return broken("a list that does not continue");
    listed_.insert(listed_.end(), page.datasets.begin(), page.datasets.end());
    if (!page.next.empty()) return list(page.next);
    infos_ = std::exchange(listed_, {});
    begin();
  }
  [[nodiscard]] const Wish& wish() const { return wishes_.at(surfaces_); }

  // Requests the surface, first or again.
  void begin() {
    const auto info = std::find_if(infos_.begin(), infos_.end(), [&](const DatasetInfo& one) {
      return one.name == wish().dataset;
    });
    if (info == infos_.end()) {
      if (weather_.lies == 0) report_("a dataset is missing from the list");
      return link_->cut();
    }
    const bool is_replaced = info_ && *info_ != *info;
    if (!open_ || is_replaced) {
      open_ =
          OpenStream{.dataset = wish().dataset, .request = wish().request, .steps = wish().steps};
      given_.clear();
      started_.clear();
    }
    info_ = *info;
    open_->request_id = ++last_request_id_;
    open_->cached_tile_digests = tiles_.digests_to_name();
    named_ = {open_->cached_tile_digests.begin(), open_->cached_tile_digests.end()};
    begun_.reset();
    arrived_.clear();
    assembler_.emplace(*info_, *open_, tiles_.tiles());
    send(*open_);
    // Some users change their mind.
    if (world_.chance(0.15)) {
      world_.after(world_.uniform(0, 3),
                   [self = shared_from_this(), link = link_number_, id = open_->request_id] {
                     const bool is_it = link == self->link_number_ && self->open_ &&
                                        self->open_->request_id == id && self->assembler_;
                     if (!is_it || !self->link_->is_open()) return;
                     if (self->world_.chance(0.5))
                       self->send(Cancel{id});
                     else
                       self->begin();  // The same again, which supersedes it.
                   });
    }
  }
  void assemble(const ServerMessage& message) {
    const auto progress = assembler_->receive(message);
    if (!progress) return broken(progress.error().text);
    keep(message);
    if (const auto* step = std::get_if<CommittedStepPtr>(&*progress)) {
      committed(**step);
    } else if (const auto* refusal = std::get_if<Refusal>(&*progress)) {
      refused(refusal->error);
    } else if (const auto* end = std::get_if<StreamEnd>(&*progress)) {
      ended(end->outcome);
    }
  }
  void keep(const ServerMessage& message) {
    if (const auto* begin = std::get_if<StepBegin>(&message)) {
      if (begin->request_id != open_->request_id) return;
      begun_ = *begin;
      started(*begin);
      if (!record_started_step(*begin, *open_)) return broken("a step that is not finer");
      // What a cut interrupts most seldom by itself: a step that is short.
      if (weather_.cuts > 0 && world_.chance(0.1)) {
        world_.after(0, [link = link_] { link->cut(); });
      }
    } else if (const auto* tile = std::get_if<Tile>(&message)) {
      if (tile->request_id != open_->request_id) return;
      const ContentDigest digest = begun_->tiles.at(tile->index).digest;
      const bool is_known =
          named_.contains(digest) || std::count(arrived_.begin(), arrived_.end(), digest) > 0;
      if (is_known) report_("a tile was sent twice");
      arrived_.push_back(digest);
      keep_decoded();
      keep_in_folder(*tile);
    }
  }
  // A stream that is resumed repeats what had started, and plans nothing else in its place.
  void started(const StepBegin& begin) {
    StepBegin anonymous = begin;
    anonymous.request_id = 0;
    const std::string text = serialize(ServerMessage(anonymous));
    if (begin.step >= started_.size()) return started_.push_back(text);
    if (started_[begin.step] != text && weather_.lies == 0) {
      report_("a step differs from the one that had started before the connection was lost");
    }
  }
  void keep_in_folder(const Tile& tile) {
    if (!folder_ || begun_->shell) return;
    const FullDisk disk(world_.chance(folder_->full));
    try {
      folder_->tiles.keep(begun_->tiles.at(tile.index), begun_->request.lattice_resolution,
                          begun_->request.normal_bits, *tile.payload);
    } catch (const std::system_error&) {
      return;
    }
  }
  void keep_decoded() {
    if (!assembler_) return;
    for (const ContentDigest& digest : arrived_) {
      const auto found = assembler_->held().find(digest);
      if (found != assembler_->held().end()) tiles_.keep(digest, found->second);
    }
  }
  void committed(const CommittedStep& step) {
    const std::size_t number = step.begin.step;
    const bool is_lied_to = weather_.lies > 0;
    if (number < given_.size()) {
      if (given_[number] != step.end.digest && !is_lied_to) {
        report_("a step differs from that before the connection was lost");
      }
    } else {
      given_.push_back(step.end.digest);
    }
    final_ = step.begin.is_final ? std::optional(step.end.digest) : std::nullopt;
    if (final_ && !is_lied_to && *final_ != wish().final_digests.at(info_->content_id)) {
      report_("a final step is not the one that the request determines");
    }
  }
  void refused(const Error& error) {
    assembler_.reset();
    const bool is_damage = wish().may_be_damaged && error.code == ErrorCode::kDamagedData;
    if (error.code != ErrorCode::kUnavailable && !is_damage) {
      if (weather_.lies == 0) report_("a valid request was refused: " + error.text);
      return link_->cut();
    }
    world_.after(std::max(error.retry_after, 0.5),
                 [self = shared_from_this(), link = link_number_] {
                   if (link == self->link_number_ && self->link_->is_open()) self->list();
                 });
  }
  void ended(StreamOutcome outcome) {
    if (outcome == StreamOutcome::kComplete && !final_ && weather_.lies == 0) {
      report_("a stream is complete without its final step");
    }
    final_.reset();
    assembler_.reset();
    open_.reset();
    info_.reset();
    if (++surfaces_ == wishes_.size()) return finish();
    begin();
  }
  void finish() {
    is_done_ = true;
    link_->cut();
  }

  World& world_;
  const std::vector<Peer*> peers_;
  const Weather weather_;
  const std::vector<Wish> wishes_;
  const std::unique_ptr<TileFolder> folder_;
  const Report report_;

  LinkPtr link_;
  std::uint64_t link_number_ = 0;  // Odd or even: whether there is one.
  FrameReader reader_{kMaxServerFrameBytes};
  bool heard_ = false;
  int attempts_ = 0;
  std::uint64_t last_request_id_ = 0;
  std::vector<DatasetInfo> listed_, infos_;

  DecodedTileCache tiles_;
  std::optional<DatasetInfo> info_;
  std::optional<OpenStream> open_;
  std::optional<Assembler> assembler_;
  std::optional<StepBegin> begun_;
  std::set<ContentDigest> named_;       // By the running request.
  std::vector<ContentDigest> arrived_;  // Since it.
  std::vector<ContentDigest> given_;    // The steps that the user has seen.
  std::vector<std::string> started_;    // Those that have begun, without numbers of requests.
  std::optional<ContentDigest> final_;
  std::size_t surfaces_ = 0;
  bool is_done_ = false;
};

}  // namespace multitetra::simulation
