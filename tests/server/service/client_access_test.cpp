#include "server/service/client_access.hpp"

#include <array>

#include <gtest/gtest.h>

#include "tests/support/fake_steps.hpp"

namespace multitetra {
namespace {

using testing::fake_catalogue;
using testing::FakeSteps;

AccessListPtr list_of(const std::string& token, const std::string& datasets) {
  auto list = std::make_shared<AccessList>();
  list->add({.digest = digest_of_token(token), .rights = AccessRights("alice", {datasets})});
  return list;
}

// FakeSteps of a dataset with another description.
class ChangedSteps : public FakeSteps {
 public:
  template <typename Change>
  ChangedSteps(const std::string& name, const Change& change)
      : FakeSteps(name), info_(FakeSteps(name).info()) {
    change(info_);
  }
  [[nodiscard]] const DatasetInfo& info() const override { return info_; }

 private:
  DatasetInfo info_;
};

TEST(ClientAccess, ShowsAllDatasetsWithoutAnAccessList) {
  const auto client_access = ClientAccess::of("whatever", nullptr, fake_catalogue("head"));
  ASSERT_TRUE(client_access);
  EXPECT_FALSE(client_access->has_token());
  EXPECT_TRUE(client_access->describe("head"));
  EXPECT_EQ(client_access->list().datasets.size(), 1U);
}

TEST(ClientAccess, RefusesRequestsForADatasetThatWasReplaced) {
  const auto access = ClientAccess::of("", nullptr,
                                       testing::catalogue_of(std::make_shared<ChangedSteps>(
                                           "head", [](DatasetInfo& i) { i.content_id = 7; })));
  ASSERT_TRUE(access);
  const auto refused = [&](auto request, std::uint64_t content_id) {
    request.content_id = content_id;
    const auto accepted = access->accept(std::move(request));
    return !accepted && accepted.error().code == ErrorCode::kUnavailable;
  };
  const Probe probe{.dataset = "head", .probe = {.places = {{0, 0, 0}}}};
  for (const auto& [content_id, is_refused] : {std::pair(0, false), {7, false}, {8, true}}) {
    const auto id = static_cast<std::uint64_t>(content_id);
    EXPECT_EQ(refused(testing::open_fake(1, "head"), id), is_refused) << id;
    EXPECT_EQ(refused(Estimate{.dataset = "head"}, id), is_refused) << id;
    EXPECT_EQ(refused(probe, id), is_refused) << id;
  }
  // A gateway's server is asked for the one that the client knows.
  EXPECT_EQ(access->accept(testing::open_fake(1, "head"))->open.content_id, 7U);
  EXPECT_EQ(std::get<Probe>(access->accept(probe)->query).content_id, 7U);
}

TEST(ClientAccess, RejectsUnknownTokens) {
  const AccessListPtr list = list_of("good", "*");
  const auto refused = ClientAccess::of("bad", list, fake_catalogue("head"));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnauthenticated);
  EXPECT_TRUE(ClientAccess::of("good", list, fake_catalogue("head")));
}

TEST(ClientAccess, TellsHowFarAVolumeIsRead) {
  const auto catalogue = std::make_shared<DatasetCatalogue>([] {
    return std::vector<DatasetReading>{{"head", 0.371}, {"frog-1", 0.5}};
  });
  catalogue->add(std::make_shared<FakeSteps>("frog-1"));  // Served by now.
  const auto client_access = ClientAccess::of("", nullptr, catalogue);
  ASSERT_EQ(client_access->readings().size(), 1U);
  EXPECT_EQ(client_access->readings().front().name, "head");
  const auto head = client_access->describe("head");
  ASSERT_FALSE(head);
  EXPECT_EQ(head.error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(head.error().retry_after, 1);
  EXPECT_NE(head.error().text.find("37 %"), std::string::npos) << head.error().text;
  const auto other = ClientAccess::of("good", list_of("good", "frog-*"), catalogue);
  EXPECT_TRUE(other->readings().empty());
  EXPECT_EQ(other->describe("head").error().code, ErrorCode::kUnknownDataset);
}

TEST(ClientAccess, ReportsHiddenDatasetsAsUnknown) {
  const auto client_access =
      ClientAccess::of("good", list_of("good", "frog-*"), fake_catalogue("head"));
  ASSERT_TRUE(client_access);
  EXPECT_TRUE(client_access->list().datasets.empty());
  EXPECT_FALSE(client_access->may_see("head"));
  const auto job = client_access->accept(testing::open_fake(1, "head"));
  ASSERT_FALSE(job);
  EXPECT_EQ(job.error().code, ErrorCode::kUnknownDataset);
  EXPECT_EQ(client_access->accept(Probe{.dataset = "head", .probe = {.places = {{0, 0, 0}}}})
                .error()
                .code,
            ErrorCode::kUnknownDataset);
}

TEST(ClientAccess, SuggestsOnlyVisibleDatasets) {
  const auto catalogue = fake_catalogue("head");
  catalogue->add(std::make_shared<FakeSteps>("frog-1"));
  const auto text = [&](const std::string& datasets, const std::string& wanted) {
    return ClientAccess::of("good", list_of("good", datasets), catalogue)
        ->describe(wanted)
        .error()
        .text;
  };
  EXPECT_NE(text("*", "haed").find("Did you mean \"head\"?"), std::string::npos);
  EXPECT_EQ(text("frog-*", "haed").find("Did you mean"), std::string::npos);
  EXPECT_NE(text("frog-*", "frog1").find("Did you mean \"frog-1\"?"), std::string::npos);
}

TEST(ClientAccess, ChecksTheRightsOfColorDatasets) {
  const auto catalogue = fake_catalogue("head");
  catalogue->add(std::make_shared<FakeSteps>("dose"));
  OpenStream open = testing::open_fake(1, "head");
  open.scalars = ScalarRequest{.dataset = "dose"};
  EXPECT_TRUE(ClientAccess::of("", nullptr, catalogue)->accept(open));
  const auto refused = ClientAccess::of("good", list_of("good", "head"), catalogue)->accept(open);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnknownDataset);
}

TEST(ClientAccess, RefusesColorsOfAnotherWorldUnlessAllowed) {
  const auto catalogue = fake_catalogue("head");
  catalogue->add(std::make_shared<ChangedSteps>("dose", [](DatasetInfo& info) {
    info.index_to_world.translation = {1e6, 0, 0};
  }));
  OpenStream open = testing::open_fake(1, "head");
  open.scalars = ScalarRequest{.dataset = "dose"};
  const auto refused = ClientAccess::of("", nullptr, catalogue)->accept(open);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text.find("different positions"), std::string::npos);
  open.scalars->in_any_world = true;
  EXPECT_TRUE(ClientAccess::of("", nullptr, catalogue)->accept(open));
}

TEST(ClientAccess, ChecksRightsAndGridsOfFurtherDatasets) {
  const auto catalogue = fake_catalogue("head");
  catalogue->add(std::make_shared<FakeSteps>("dose"));
  const auto add_changed = [&](const char* name, auto change) {
    catalogue->add(std::make_shared<ChangedSteps>(name, change));
  };
  add_changed("embryo", [](DatasetInfo& info) { info.dims[0] = 33; });
  add_changed("of floats", [](DatasetInfo& info) { info.type = SampleType::kF32; });
  add_changed("in air", [](DatasetInfo& info) { info.outside = -1000; });
  add_changed("with holes", [](DatasetInfo& info) { info.void_samples = 1; });
  const auto accept = [&](const ClientAccess& client_access, std::vector<std::string> further) {
    OpenStream open = testing::open_fake(1, "head", StepPolicy::kPreviewsOnly);
    open.resumed_previews = {{.finest_spacing = 4}};
    open.further_datasets = std::move(further);
    return client_access.accept(std::move(open));
  };
  const auto all = ClientAccess::of("", nullptr, catalogue);
  EXPECT_EQ(accept(*all, {"dose", "head"})->further.size(), 2U);
  EXPECT_EQ(accept(*all, {"dose", "none"}).error().code, ErrorCode::kUnknownDataset);
  for (const char* const other : {"embryo", "of floats", "in air", "with holes"}) {
    EXPECT_EQ(accept(*all, {other}).error().code, ErrorCode::kInvalidArgument) << other;
  }
  const auto alone = ClientAccess::of("good", list_of("good", "head"), catalogue);
  EXPECT_EQ(accept(*alone, {"dose"}).error().code, ErrorCode::kUnknownDataset);
}

TEST(ClientAccess, AllowsShellsForClientsThatDecodeThemAndMaySeeSamples) {
  constexpr std::array kBoth = {PayloadCodec::kDracoLattice, PayloadCodec::kSampleShell};
  const std::vector<PayloadCodec> both(kBoth.begin(), kBoth.end());
  AccessRights meshes_alone("bob", {"*"});
  meshes_alone.allow_surfaces_only();
  auto list = std::make_shared<AccessList>();
  list->add({.digest = digest_of_token("samples"), .rights = AccessRights("alice", {"*"})});
  list->add({.digest = digest_of_token("surfaces"), .rights = meshes_alone});
  const auto permit_of = [&](const std::string& token, const std::vector<PayloadCodec>& codecs) {
    auto client_access = ClientAccess::of(token, list, fake_catalogue("head")).value();
    client_access.set_codecs(codecs);
    return client_access;
  };
  const auto with_shells = permit_of("samples", both);
  EXPECT_EQ(with_shells.codecs(), both);
  EXPECT_TRUE(with_shells.accept(testing::open_fake(1, "head"))->shells);
  for (const auto& without :
       {permit_of("surfaces", both), permit_of("samples", {PayloadCodec::kDracoLattice})}) {
    EXPECT_EQ(without.codecs(), std::vector{PayloadCodec::kDracoLattice});
    EXPECT_FALSE(without.accept(testing::open_fake(1, "head"))->shells);
    OpenStream open = testing::open_fake(1, "head");
    open.resumed_previews = {{.finest_spacing = 4, .shell = quantized_shells(2)}};
    const auto refused = without.accept(open);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
    EXPECT_TRUE(with_shells.accept(open));
  }
}

// A dataset for which the server sends no shells.
class StepsWithoutShells : public FakeSteps {
 public:
  using FakeSteps::FakeSteps;
  [[nodiscard]] bool sends_shells() const override { return false; }
};

TEST(ClientAccess, ReturnsCachedShellsOnlyToClientsThatMaySeeSamples) {
  AccessRights meshes_alone("bob", {"*"});
  meshes_alone.allow_surfaces_only();
  auto list = std::make_shared<AccessList>();
  list->add({.digest = digest_of_token("samples"), .rights = AccessRights("alice", {"head"})});
  list->add({.digest = digest_of_token("surfaces"), .rights = meshes_alone});
  const auto catalogue = fake_catalogue("head");
  catalogue->add(std::make_shared<FakeSteps>("foot"));
  catalogue->add(std::make_shared<StepsWithoutShells>("hand"));
  const ClientAccess alice = ClientAccess::of("samples", list, catalogue).value();
  EXPECT_TRUE(alice.may_see_shells("head"));
  EXPECT_FALSE(alice.may_see_shells("foot"));
  const ClientAccess bob = ClientAccess::of("surfaces", list, catalogue).value();
  EXPECT_TRUE(bob.may_see("head"));
  EXPECT_FALSE(bob.may_see_shells("head"));
  const ClientAccess anyone = ClientAccess::of("", nullptr, catalogue).value();
  EXPECT_TRUE(anyone.may_see_shells("head"));
  EXPECT_FALSE(anyone.may_see_shells("hand"));
  EXPECT_FALSE(anyone.may_see_shells("nothing"));
  EXPECT_FALSE(
      ClientAccess::of("", nullptr, catalogue, {.surfaces_only = true})->may_see_shells("head"));
}

TEST(ClientAccess, RejectsSamplesForSurfacesOnlyTokens) {
  AccessRights meshes_alone("bob", {"*"});
  meshes_alone.allow_surfaces_only();
  auto list = std::make_shared<AccessList>();
  list->add({.digest = digest_of_token("surfaces"), .rights = meshes_alone});
  for (const auto& client_access :
       {ClientAccess::of("surfaces", list, fake_catalogue("head")).value(),
        ClientAccess::of("", nullptr, fake_catalogue("head"), {.surfaces_only = true}).value()}) {
    EXPECT_TRUE(client_access.accept(testing::open_fake(1, "head")));
    EXPECT_TRUE(client_access.accept(Estimate{.dataset = "head"}));
    EXPECT_EQ(client_access.accept(Probe{.dataset = "head", .probe = {.places = {{0, 0, 0}}}})
                  .error()
                  .code,
              ErrorCode::kPermissionDenied);
    const SliceRequest plane{.right = {1, 0, 0}, .down = {0, 1, 0}, .width = 2, .height = 2};
    EXPECT_EQ(client_access.accept(Slice{.dataset = "head", .slice = plane}).error().code,
              ErrorCode::kPermissionDenied);
    // What is not permitted is not validated either.
    EXPECT_EQ(client_access.accept(Slice{.dataset = "head", .slice = {}}).error().code,
              ErrorCode::kPermissionDenied);
  }
}

TEST(ClientAccess, RejectsFieldsForSurfacesOnlyTokensWithoutColors) {
  AccessRights plain("bob", {"*"});
  plain.allow_surfaces_only();
  AccessRights colored("eve", {"*"});
  colored.allow_surfaces_only(/*colors=*/true);
  auto list = std::make_shared<AccessList>();
  list->add({.digest = digest_of_token("plain"), .rights = plain});
  list->add({.digest = digest_of_token("colored"), .rights = colored});
  list->add({.digest = digest_of_token("all"), .rights = AccessRights("alice", {"*"})});
  OpenStream open = testing::open_fake(1, "head");
  open.scalars = ScalarRequest{.dataset = "head"};
  const auto code_of = [&](const Result<ClientAccess>& client_access) {
    const auto accepted = client_access->accept(open);
    return accepted ? std::nullopt : std::optional(accepted.error().code);
  };
  const auto catalogue = fake_catalogue("head");
  EXPECT_EQ(code_of(ClientAccess::of("plain", list, catalogue)), ErrorCode::kPermissionDenied);
  EXPECT_EQ(code_of(ClientAccess::of("", nullptr, catalogue, {.surfaces_only = true})),
            ErrorCode::kPermissionDenied);
  EXPECT_EQ(code_of(ClientAccess::of("colored", list, catalogue)), std::nullopt);
  EXPECT_EQ(code_of(ClientAccess::of("all", list, catalogue)), std::nullopt);
  EXPECT_EQ(code_of(ClientAccess::of("", nullptr, catalogue)), std::nullopt);
}

// A gateway has no tokens, but its upstream servers send this client no samples.
TEST(ClientAccess, OffersNoSamplesThatUpstreamServersDoNotSend) {
  auto catalogue = std::make_shared<DatasetCatalogue>();
  EXPECT_TRUE(ClientAccess::of("", nullptr, catalogue)->check_samples());
  catalogue->add(std::make_shared<StepsWithoutShells>("head"));
  auto client_access = ClientAccess::of("", nullptr, catalogue).value();
  client_access.set_codecs({PayloadCodec::kDracoLattice, PayloadCodec::kSampleShell});
  EXPECT_EQ(client_access.codecs(), std::vector{PayloadCodec::kDracoLattice});
  EXPECT_EQ(client_access.check_samples().error().code, ErrorCode::kPermissionDenied);
  catalogue->add(std::make_shared<FakeSteps>("foot"));
  EXPECT_TRUE(client_access.check_samples());
}

TEST(ClientAccess, RejectsShellPreviewsThatTheDatasetCannotHave) {
  auto client_access = ClientAccess::of("", nullptr, fake_catalogue("head")).value();
  client_access.set_codecs({PayloadCodec::kDracoLattice, PayloadCodec::kSampleShell});
  OpenStream open = testing::open_fake(1, "head");
  // The grid has 64 steps per side.
  open.resumed_previews = {{.finest_spacing = 64, .shell = quantized_shells(2)}};
  EXPECT_FALSE(client_access.accept(open));
  open.resumed_previews = {{.finest_spacing = 32, .shell = quantized_shells(2)}};
  EXPECT_TRUE(client_access.accept(open));
  open.request.normal_bits = 8;
  EXPECT_FALSE(client_access.accept(open));
}

TEST(ClientAccess, AppliesAReloadedListAtOnce) {
  auto client_access = ClientAccess::of("good", list_of("good", "*"), fake_catalogue("head"));
  ASSERT_TRUE(client_access);
  EXPECT_FALSE(client_access->renew(list_of("other", "*")));
  EXPECT_TRUE(client_access->renew(list_of("good", "frog")));
  EXPECT_FALSE(client_access->may_see("head"));
}

TEST(ClientAccess, DescribesDatasetsWhileRejectingWork) {
  auto client_access = ClientAccess::of("", nullptr, fake_catalogue("head"));
  client_access->reject_requests({ErrorCode::kUnavailable, "stopping"});
  EXPECT_TRUE(client_access->describe("head"));
  EXPECT_EQ(client_access->accept(testing::open_fake(1, "head")).error().code,
            ErrorCode::kUnavailable);
}

}  // namespace
}  // namespace multitetra
