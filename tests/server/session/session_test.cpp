#include "server/session/session.hpp"

#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "tests/support/fake_steps.hpp"

namespace multitetra {
namespace {

using testing::FakeSteps;

// ---- actions as text

struct Describe {
  std::string operator()(const Send& send) const {
    if (const auto* error = std::get_if<ErrorReply>(&send.message)) {
      return "error " + std::string(name(error->error.code)) + " " +
             std::to_string(error->request_id);
    }
    if (std::holds_alternative<Welcome>(send.message)) return "welcome";
    if (const auto* pong = std::get_if<Pong>(&send.message)) {
      return "pong " + std::to_string(pong->value) + (pong->requires_token ? " with token" : "");
    }
    if (const auto* list = std::get_if<DatasetList>(&send.message)) {
      return "list " + std::to_string(list->request_id) + " of " +
             std::to_string(list->encoded.size());
    }
    return "another message";
  }
  std::string operator()(const ValidatedStream& start) const {
    return "start " + std::to_string(start.open.request_id);
  }
  std::string operator()(const ValidatedQuery& requested) const {
    return std::string(kind_of(requested.query)) + " " +
           std::to_string(request_id_of(requested.query));
  }
  std::string operator()(const StopStream& stop) const {
    const std::string stopped = "stop " + std::to_string(stop.request_id) + " ";
    if (const auto* error = std::get_if<Error>(&stop.outcome)) {
      return stopped + std::string(name(error->code));
    }
    const bool is_superseded = std::get<StreamOutcome>(stop.outcome) == StreamOutcome::kSuperseded;
    return stopped + (is_superseded ? "superseded" : "cancelled");
  }
  std::string operator()(const Close&) const { return "close"; }
};

std::vector<std::string> words(const Actions& actions) {
  std::vector<std::string> result;
  for (const Action& action : actions) result.push_back(std::visit(Describe{}, action));
  return result;
}

using Words = std::vector<std::string>;

Session fresh_session() {
  auto catalogue = std::make_shared<DatasetCatalogue>();
  catalogue->add(std::make_shared<FakeSteps>("head"));
  catalogue->add(std::make_shared<FakeSteps>("tooth"));
  return Session(catalogue, {.max_held_digests = 3});
}
Session welcomed_session() {
  Session session = fresh_session();
  EXPECT_EQ(words(session.receive(Hello{})), Words{"welcome"});
  return session;
}

OpenStream open(std::uint64_t id, std::string dataset = "head") {
  return {.request_id = id,
          .dataset = std::move(dataset),
          .request = {.isovalue = 1},
          .cached_tile_digests = {}};
}

const Words kEndsWithUnexpected = {"error unexpected_message 0", "close"};

// ---- the handshake

TEST(Session, SendsTheVersionAndItsLimitInWelcome) {
  Session session = fresh_session();
  const Actions actions = session.receive(Hello{});
  ASSERT_EQ(actions.size(), 1U);
  const auto& welcome = std::get<Welcome>(std::get<Send>(actions.front()).message);
  EXPECT_EQ(welcome.version, kProtocolVersion);
  EXPECT_EQ(welcome.max_message_bytes, kMaxClientFrameBytes);
  EXPECT_TRUE(session.is_welcomed());
}

TEST(Session, EndsWhenTheFirstMessageIsNotHello) {
  const std::vector<ClientMessage> others = {ListDatasets{1}, open(1), Cancel{1}, Estimate{}};
  for (const ClientMessage& message : others) {
    Session session = fresh_session();
    EXPECT_EQ(words(session.receive(message)), kEndsWithUnexpected);
    EXPECT_TRUE(session.is_closed());
    EXPECT_TRUE(session.receive(Hello{}).empty());
  }
}

// Allows health checks without a token.
TEST(Session, AnswersPingsBeforeHello) {
  Session session = fresh_session();
  EXPECT_EQ(words(session.receive(Ping{7})), Words{"pong 7"});
  EXPECT_FALSE(session.is_welcomed());
  EXPECT_EQ(words(session.receive(Hello{})), Words{"welcome"});
}

TEST(Session, SaysBeforeHelloWhetherItRequiresAToken) {
  auto catch_as_error = std::make_shared<AccessList>();
  catch_as_error->add({.digest = digest_of_token("good"), .rights = AccessRights("alice", {"*"})});
  auto open = std::make_shared<AccessList>(*catch_as_error);
  open->add_anonymous(AccessRights("anonymous", {"*"}));
  const auto catalogue = std::make_shared<DatasetCatalogue>();
  Session session(catalogue, {}, catch_as_error);
  EXPECT_EQ(words(session.receive(Ping{7})), Words{"pong 7 with token"});
  EXPECT_EQ(words(session.receive(Hello{.token = "good"})), Words{"welcome"});
  EXPECT_EQ(words(session.receive(Ping{8})), Words{"pong 8"});
  EXPECT_EQ(words(Session(catalogue, {}, open).receive(Ping{7})), Words{"pong 7"});
}

TEST(Session, AcceptsVersionRangesThatContainItsOwn) {
  Session session = fresh_session();
  EXPECT_EQ(words(session.receive(Hello{.min_version = 0, .max_version = 9})), Words{"welcome"});
}

TEST(Session, EndsWithoutACommonVersion) {
  Session session = fresh_session();
  const Hello hello{.min_version = kProtocolVersion + 1, .max_version = kProtocolVersion + 2};
  EXPECT_EQ(words(session.receive(hello)), (Words{"error unsupported_version 0", "close"}));
}

TEST(Session, EndsWithoutACommonCodec) {
  Session session = fresh_session();
  EXPECT_EQ(words(session.receive(Hello{.codecs = {}})),
            (Words{"error invalid_argument 0", "close"}));
}

TEST(Session, SendsThePayloadCodecsInWelcome) {
  const auto codecs_for = [](std::vector<PayloadCodec> codecs) {
    const Actions actions = fresh_session().receive(Hello{.codecs = std::move(codecs)});
    return std::get<Welcome>(std::get<Send>(actions.front()).message).codecs;
  };
  const std::vector both = {PayloadCodec::kDracoLattice, PayloadCodec::kSampleShell};
  EXPECT_EQ(codecs_for(both), both);
  EXPECT_EQ(codecs_for({PayloadCodec::kDracoLattice}), std::vector{PayloadCodec::kDracoLattice});
}

TEST(Session, RejectsASecondHelloAndContinues) {
  Session session = welcomed_session();
  EXPECT_EQ(words(session.receive(Hello{})), Words{"error unexpected_message 0"});
  EXPECT_EQ(words(session.receive(Ping{7})), Words{"pong 7"});
}

// ---- requests

TEST(Session, LimitsEstimatesDuringAStream) {
  Session session = welcomed_session();
  EXPECT_EQ(words(session.receive(open(1))), Words{"start 1"});
  for (std::uint64_t id = 1; id <= SessionOptions{}.max_queries; ++id) {
    EXPECT_EQ(words(session.receive(Estimate{.request_id = id, .dataset = "head"})),
              Words{"estimate " + std::to_string(id)});
  }
  const Estimate one_more{.request_id = 99, .dataset = "head"};
  EXPECT_EQ(words(session.receive(one_more)), Words{"error limit_exceeded 99"});
  session.query_ended();
  EXPECT_EQ(words(session.receive(one_more)), Words{"estimate 99"});
}

TEST(Session, LimitsSlicesAndProbesLikeEstimates) {
  Session session = welcomed_session();
  EXPECT_EQ(words(session.receive(Slice{.request_id = 1, .dataset = "head"})), Words{"slice 1"});
  const Probe probe{.request_id = 2, .dataset = "tooth", .probe = {.places = {{0, 0, 0}}}};
  EXPECT_EQ(words(session.receive(probe)), Words{"probe 2"});
  EXPECT_EQ(words(session.receive(Slice{.request_id = 3, .dataset = "nothing"})),
            Words{"error unknown_dataset 3"});
  EXPECT_EQ(words(session.receive(Probe{.request_id = 4, .dataset = "head"})),
            Words{"error invalid_argument 4"});
  for (std::size_t i = 2; i < SessionOptions{}.max_queries; ++i) {
    EXPECT_EQ(words(session.receive(probe)), Words{"probe 2"});
  }
  EXPECT_EQ(words(session.receive(Slice{.request_id = 5, .dataset = "head"})),
            Words{"error limit_exceeded 5"});
  session.query_ended();
  EXPECT_EQ(words(session.receive(Slice{.request_id = 5, .dataset = "head"})), Words{"slice 5"});
}

TEST(Session, RejectsEstimatesOfInvalidStreams) {
  Session session = welcomed_session();
  EXPECT_EQ(words(session.receive(Estimate{.request_id = 3, .dataset = "nothing"})),
            Words{"error unknown_dataset 3"});
  EXPECT_EQ(words(session.receive(
                Estimate{.request_id = 4, .dataset = "head", .request = {.error = -1}})),
            Words{"error invalid_argument 4"});
  EXPECT_EQ(words(session.receive(Estimate{.request_id = 5, .dataset = "head"})),
            Words{"estimate 5"});
}

TEST(Session, ListsItsDatasets) {
  Session session = welcomed_session();
  EXPECT_EQ(words(session.receive(ListDatasets{5})), Words{"list 5 of 2"});
}

TEST(Session, StartsAStreamOfAKnownDataset) {
  Session session = welcomed_session();
  const Actions actions = session.receive(open(1, "tooth"));
  ASSERT_EQ(words(actions), Words{"start 1"});
  EXPECT_EQ(std::get<ValidatedStream>(actions.front()).source->info().name, "tooth");
}

TEST(Session, SupersedesTheRunningStream) {
  Session session = welcomed_session();
  (void)session.receive(open(1));
  EXPECT_EQ(words(session.receive(open(2))), (Words{"stop 1 superseded", "start 2"}));
}

TEST(Session, SupersedesNothingAfterAStreamsEnd) {
  Session session = welcomed_session();
  (void)session.receive(open(1));
  session.stream_ended(1);
  EXPECT_EQ(words(session.receive(open(2))), Words{"start 2"});
}

TEST(Session, StopsTheRunningStreamOnceOnCancel) {
  Session session = welcomed_session();
  (void)session.receive(open(4));
  EXPECT_EQ(words(session.receive(Cancel{4})), Words{"stop 4 cancelled"});
  EXPECT_EQ(words(session.receive(Cancel{4})), Words{});
}

TEST(Session, IgnoresCancelOfAnotherStream) {
  Session session = welcomed_session();
  (void)session.receive(open(4));
  EXPECT_EQ(words(session.receive(Cancel{3})), Words{});
  EXPECT_EQ(words(session.receive(Cancel{5})), Words{});
  EXPECT_EQ(words(session.receive(open(5))), (Words{"stop 4 superseded", "start 5"}));
}

TEST(Session, RejectsAnInvalidRequestAndKeepsTheRunningStream) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  OpenStream nan_isovalue = open(2);
  nan_isovalue.request.isovalue = nan;
  OpenStream negative_error = open(2);
  negative_error.request.error = -1;
  OpenStream fine_lattice = open(2);
  fine_lattice.request.lattice_resolution = kMaxLatticeResolution + 1;
  OpenStream many_held = open(2);
  many_held.cached_tile_digests.resize(4);
  const std::vector<std::pair<OpenStream, std::string>> bad = {
      {nan_isovalue, "invalid_argument 2"},
      {negative_error, "invalid_argument 2"},
      {fine_lattice, "invalid_argument 2"},
      {many_held, "limit_exceeded 2"},
      {open(2, "nothing"), "unknown_dataset 2"},
      {open(1), "invalid_argument 1"},
      {open(0), "invalid_argument 0"}};
  for (const auto& [request, answer] : bad) {
    Session session = welcomed_session();
    (void)session.receive(open(1));
    EXPECT_EQ(words(session.receive(request)), Words{"error " + answer});
    EXPECT_EQ(words(session.receive(Cancel{1})), Words{"stop 1 cancelled"});
    EXPECT_EQ(words(session.receive(open(3))), Words{"start 3"});
  }
}

TEST(Session, AllowsTheIdOfARejectedRequestAgain) {
  Session session = welcomed_session();
  EXPECT_EQ(words(session.receive(open(1, "nothing"))), Words{"error unknown_dataset 1"});
  EXPECT_EQ(words(session.receive(open(1))), Words{"start 1"});
}

TEST(Session, RejectsALatticeTooFineForALargeDataset) {
  class Large : public FakeSteps {
   public:
    Large() : FakeSteps("large") {
      info_ = testing::octahedra_info("large"), info_.grid_exponent = 13;
    }
    const DatasetInfo& info() const override { return info_; }

   private:
    DatasetInfo info_;
  };
  Session session(testing::catalogue_of(std::make_shared<Large>()), {});
  (void)session.receive(Hello{});
  OpenStream request = open(1, "large");
  request.request.lattice_resolution = 8;
  EXPECT_EQ(words(session.receive(request)), Words{"error invalid_argument 1"});
  request.request_id = 2;
  request.request.lattice_resolution = 7;
  EXPECT_EQ(words(session.receive(request)), Words{"start 2"});
}

TEST(Session, RejectsCellsOutsideTheGrid) {
  class Of64Steps : public FakeSteps {
   public:
    Of64Steps() : FakeSteps("grid") {
      info_ = testing::octahedra_info("grid"), info_.grid_exponent = 6;
    }
    const DatasetInfo& info() const override { return info_; }

   private:
    DatasetInfo info_;
  };
  Session session(testing::catalogue_of(std::make_shared<Of64Steps>()), {});
  (void)session.receive(Hello{});
  std::uint64_t id = 0;
  const auto answer_to = [&](const OctreeCube& cube) {
    OpenStream request = open(++id, "grid");
    request.request.cell = OctreeNode{.cube = cube};
    return words(session.receive(request)).back();
  };
  EXPECT_EQ(answer_to({6, 0, 0, 0}), "start 1");
  EXPECT_EQ(answer_to({4, 3, 3, 3}), "start 2");
  EXPECT_EQ(answer_to({4, 3, 4, 3}), "error invalid_argument 3");
  EXPECT_EQ(answer_to({7, 0, 0, 0}), "error invalid_argument 4");
  EXPECT_EQ(answer_to({3, 0, 0, 0}), "error invalid_argument 5");
}

TEST(Session, RejectsFieldsOutsideTheirRangeWithTheRequestId) {
  Session session = welcomed_session();
  const ParseError error{{ErrorCode::kInvalidArgument, "..."}, 9};
  EXPECT_EQ(words(session.receive(error)), Words{"error invalid_argument 9"});
  EXPECT_FALSE(session.is_closed());
}

TEST(Session, EndsWithAReasonAfterInvalidBytes) {
  Session session = welcomed_session();
  (void)session.receive(open(1));
  const ParseError error{{ErrorCode::kMalformedMessage, "..."}, 0};
  EXPECT_EQ(words(session.receive(error)),
            (Words{"stop 1 malformed_message", "error malformed_message 0", "close"}));
}

// ---- every conversation, failing at every message

struct Happening {
  std::string name;
  std::function<Actions(Session&)> happen;
};

std::vector<Happening> a_conversation() {
  const auto says = [](ClientMessage message) {
    return [message = std::move(message)](Session& session) { return session.receive(message); };
  };
  return {{"hello", says(Hello{})},
          {"list", says(ListDatasets{1})},
          {"open 1", says(open(1))},
          {"ping", says(Ping{3})},
          {"open 2", says(open(2, "tooth"))},
          {"cancel 2", says(Cancel{2})},
          {"open 3", says(open(3))},
          {"bad open", says(open(4, "nothing"))},
          {"end of 3",
           [](Session& session) {
             session.stream_ended(3);
             return Actions{};
           }},
          {"open 5", says(open(5))}};
}

std::vector<Happening> all_failures() {
  return {{"a broken frame",
           [](Session& s) {
             return s.end({ErrorCode::kMalformedFrame, "..."});
           }},
          {"no message",
           [](Session& s) {
             return s.receive(ParseError{{ErrorCode::kMalformedMessage, "..."}, 0});
           }},
          {"a bad field",
           [](Session& s) {
             return s.receive(ParseError{{ErrorCode::kInvalidArgument, "..."}, 1});
           }},
          {"another hello", [](Session& s) { return s.receive(Hello{}); }},
          {"an old id", [](Session& s) { return s.receive(open(1)); }},
          {"a stray cancel", [](Session& s) { return s.receive(Cancel{77}); }}};
}

// Checks the guarantees that the header of Session states for all actions.
class Watcher {
 public:
  void watch(const Actions& actions) {
    for (const Action& action : actions) {
      EXPECT_FALSE(is_closed_) << "something follows Close";
      if (const auto* start = std::get_if<ValidatedStream>(&action)) {
        EXPECT_EQ(running_, 0U) << "two streams at once";
        running_ = start->open.request_id;
      } else if (const auto* stop = std::get_if<StopStream>(&action)) {
        EXPECT_EQ(running_, stop->request_id) << "stops a stream that does not run";
        running_ = 0;
      } else if (std::holds_alternative<Close>(action)) {
        EXPECT_EQ(running_, 0U) << "closes with a running stream";
        is_closed_ = true;
      }
    }
  }
  void ended(std::uint64_t id) {
    if (running_ == id) running_ = 0;
  }
  [[nodiscard]] bool is_closed() const { return is_closed_; }

 private:
  std::uint64_t running_ = 0;
  bool is_closed_ = false;
};

TEST(Session, KeepsItsGuaranteesAfterAnyErrorAtAnyMessage) {
  const auto conversation = a_conversation();
  for (const Happening& failure : all_failures()) {
    for (std::size_t at = 0; at <= conversation.size(); ++at) {
      SCOPED_TRACE(failure.name + " before message " + std::to_string(at));
      Session session = fresh_session();
      Watcher watcher;
      for (std::size_t i = 0; i < conversation.size(); ++i) {
        if (i == at) watcher.watch(failure.happen(session));
        if (conversation[i].name == "end of 3") watcher.ended(3);
        watcher.watch(conversation[i].happen(session));
      }
      EXPECT_EQ(watcher.is_closed(), session.is_closed());
    }
  }
}

TEST(Session, KeepsItsGuaranteesAfterAnyLostMessage) {
  const auto conversation = a_conversation();
  for (std::size_t lost = 0; lost < conversation.size(); ++lost) {
    SCOPED_TRACE("without " + conversation[lost].name);
    Session session = fresh_session();
    Watcher watcher;
    for (std::size_t i = 0; i < conversation.size(); ++i) {
      if (i == lost) continue;
      if (conversation[i].name == "end of 3") watcher.ended(3);
      watcher.watch(conversation[i].happen(session));
    }
    EXPECT_EQ(session.is_closed(), lost == 0) << "only Hello cannot be missed";
  }
}

TEST(Session, RejectsPreviewsThatTheDatasetCannotHave) {
  Session session = welcomed_session();
  OpenStream stream = open(1);
  stream.resumed_previews = {{.finest_spacing = 128}};  // The grid has 64 steps per side.
  const Actions actions = session.receive(stream);
  ASSERT_EQ(actions.size(), 1U);
  const auto& refusal = std::get<ErrorReply>(std::get<Send>(actions.front()).message);
  EXPECT_EQ(refusal.error.code, ErrorCode::kInvalidArgument);
  EXPECT_NE(refusal.error.text.find("64 steps"), std::string::npos) << refusal.error.text;
  stream.resumed_previews = {{.finest_spacing = 64}};
  EXPECT_EQ(words(session.receive(stream)), Words{"start 1"});
}

TEST(Session, UsesTheDatasetsOfTheLastList) {
  CataloguePtr now = testing::catalogue_of(std::make_shared<FakeSteps>("head"));
  Session session(now, {}, nullptr, [&now] { return now; });
  (void)session.receive(Hello{});
  const auto names = [&session] {
    const Actions actions = session.receive(ListDatasets{.request_id = 1});
    std::string all;
    const auto sent = parse_server_message(serialize(std::get<Send>(actions.at(0)).message));
    for (const DatasetInfo& info : std::get<DatasetList>(*sent).datasets) all += info.name + " ";
    return all;
  };
  const auto source = [&session](std::uint64_t id, const std::string& dataset) {
    const Actions actions = session.receive(
        OpenStream{.request_id = id, .dataset = dataset, .cached_tile_digests = {}});
    const auto* start = std::get_if<ValidatedStream>(&actions.back());
    return start != nullptr ? start->source : nullptr;
  };
  const auto has_new_list = [&session] {
    const Actions actions = session.receive(Ping{});
    return std::get<Pong>(std::get<Send>(actions.at(0)).message).has_new_list;
  };
  EXPECT_FALSE(has_new_list()) << "without a list";
  EXPECT_EQ(names(), "head ");
  EXPECT_FALSE(has_new_list());
  const auto before = source(2, "head");
  auto next = testing::catalogue_of(std::make_shared<FakeSteps>("head"));
  next->add(std::make_shared<FakeSteps>("tooth"));
  now = next;
  EXPECT_TRUE(has_new_list());
  EXPECT_EQ(source(3, "head"), before) << "the announced tiles are unchanged";
  EXPECT_EQ(source(4, "tooth"), nullptr);
  EXPECT_EQ(names(), "head tooth ");
  EXPECT_FALSE(has_new_list());
  EXPECT_NE(source(5, "head"), before);
  EXPECT_NE(source(6, "tooth"), nullptr);
}

TEST(Session, UsesTheLatestDatasetsWithoutAList) {
  CataloguePtr now = testing::catalogue_of(std::make_shared<FakeSteps>("head"));
  Session session(now, {}, nullptr, [&now] { return now; });
  (void)session.receive(Hello{});
  EXPECT_EQ(words(session.receive(open(1, "tooth"))), Words{"error unknown_dataset 1"});
  now = testing::catalogue_of(std::make_shared<FakeSteps>("tooth"));
  EXPECT_EQ(words(session.receive(open(2, "tooth"))), Words{"start 2"});
}

TEST(DatasetCatalogue, IsInNaturalOrderOfNames) {
  DatasetCatalogue catalogue;
  for (const char* name : {"cells.label10", "cells.label2", "cells.label1"}) {
    catalogue.add(std::make_shared<FakeSteps>(name));
  }
  std::vector<std::string> names;
  for (const auto& [name, entry] : catalogue.entries()) names.push_back(name);
  EXPECT_EQ(names, (std::vector<std::string>{"cells.label1", "cells.label2", "cells.label10"}));
  EXPECT_EQ(catalogue.find("cells.label10")->info().name, "cells.label10");
  EXPECT_EQ(catalogue.find("cells.label3"), nullptr);
}

}  // namespace
}  // namespace multitetra
