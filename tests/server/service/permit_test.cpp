#include "server/service/permit.hpp"

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

TEST(Permit, ShowsAllDatasetsWithoutAnAccessList) {
  const auto permit = Permit::of("whatever", nullptr, fake_catalogue("head"));
  ASSERT_TRUE(permit);
  EXPECT_FALSE(permit->has_token());
  EXPECT_TRUE(permit->describe("head"));
  EXPECT_EQ(permit->describe().size(), 1U);
}

TEST(Permit, RejectsUnknownTokens) {
  const AccessListPtr list = list_of("good", "*");
  const auto refused = Permit::of("bad", list, fake_catalogue("head"));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnauthenticated);
  EXPECT_TRUE(Permit::of("good", list, fake_catalogue("head")));
}

TEST(Permit, ReportsHiddenDatasetsAsUnknown) {
  const auto permit = Permit::of("good", list_of("good", "frog-*"), fake_catalogue("head"));
  ASSERT_TRUE(permit);
  EXPECT_TRUE(permit->describe().empty());
  EXPECT_FALSE(permit->may_see("head"));
  const auto job = permit->accept(testing::open_fake(1, "head"));
  ASSERT_FALSE(job);
  EXPECT_EQ(job.error().code, ErrorCode::kUnknownDataset);
  EXPECT_EQ(permit->accept(Probe{.dataset = "head", .probe = {.places = {{0, 0, 0}}}}).error().code,
            ErrorCode::kUnknownDataset);
}

TEST(Permit, SuggestsOnlyVisibleDatasets) {
  const auto catalogue = fake_catalogue("head");
  catalogue->add(std::make_shared<FakeSteps>("frog-1"));
  const auto text = [&](const std::string& datasets, const std::string& wanted) {
    return Permit::of("good", list_of("good", datasets), catalogue)->describe(wanted).error().text;
  };
  EXPECT_NE(text("*", "haed").find("Did you mean \"head\"?"), std::string::npos);
  EXPECT_EQ(text("frog-*", "haed").find("Did you mean"), std::string::npos);
  EXPECT_NE(text("frog-*", "frog1").find("Did you mean \"frog-1\"?"), std::string::npos);
}

TEST(Permit, ChecksTheRightsOfColorDatasets) {
  const auto catalogue = fake_catalogue("head");
  catalogue->add(std::make_shared<FakeSteps>("dose"));
  OpenStream open = testing::open_fake(1, "head");
  open.scalars = ScalarRequest{.dataset = "dose"};
  EXPECT_TRUE(Permit::of("", nullptr, catalogue)->accept(open));
  const auto refused = Permit::of("good", list_of("good", "head"), catalogue)->accept(open);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnknownDataset);
}

TEST(Permit, RefusesColorsOfAnotherWorldUnlessAllowed) {
  const auto catalogue = fake_catalogue("head");
  catalogue->add(std::make_shared<ChangedSteps>("dose", [](DatasetInfo& info) {
    info.index_to_world.translation = {1e6, 0, 0};
  }));
  OpenStream open = testing::open_fake(1, "head");
  open.scalars = ScalarRequest{.dataset = "dose"};
  const auto refused = Permit::of("", nullptr, catalogue)->accept(open);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text.find("different positions"), std::string::npos);
  open.scalars->in_any_world = true;
  EXPECT_TRUE(Permit::of("", nullptr, catalogue)->accept(open));
}

TEST(Permit, ChecksRightsAndGridsOfFurtherDatasets) {
  const auto catalogue = fake_catalogue("head");
  catalogue->add(std::make_shared<FakeSteps>("dose"));
  const auto add_changed = [&](const char* name, auto change) {
    catalogue->add(std::make_shared<ChangedSteps>(name, change));
  };
  add_changed("embryo", [](DatasetInfo& info) { info.dims[0] = 33; });
  add_changed("of floats", [](DatasetInfo& info) { info.type = SampleType::kF32; });
  add_changed("in air", [](DatasetInfo& info) { info.outside = -1000; });
  add_changed("with holes", [](DatasetInfo& info) { info.void_samples = 1; });
  const auto accept = [&](const Permit& permit, std::vector<std::string> further) {
    OpenStream open = testing::open_fake(1, "head", StepPolicy::kPreviewsOnly);
    open.resumed_previews = {{.finest_spacing = 4}};
    open.further_datasets = std::move(further);
    return permit.accept(std::move(open));
  };
  const auto all = Permit::of("", nullptr, catalogue);
  EXPECT_EQ(accept(*all, {"dose", "head"})->further.size(), 2U);
  EXPECT_EQ(accept(*all, {"dose", "none"}).error().code, ErrorCode::kUnknownDataset);
  for (const char* const other : {"embryo", "of floats", "in air", "with holes"}) {
    EXPECT_EQ(accept(*all, {other}).error().code, ErrorCode::kInvalidArgument) << other;
  }
  const auto alone = Permit::of("good", list_of("good", "head"), catalogue);
  EXPECT_EQ(accept(*alone, {"dose"}).error().code, ErrorCode::kUnknownDataset);
}

TEST(Permit, AllowsShellsForClientsThatDecodeThemAndMaySeeSamples) {
  constexpr std::array kBoth = {PayloadCodec::kDracoLattice, PayloadCodec::kSampleShell};
  const std::vector<PayloadCodec> both(kBoth.begin(), kBoth.end());
  AccessRights meshes_alone("bob", {"*"});
  meshes_alone.allow_surfaces_only();
  auto list = std::make_shared<AccessList>();
  list->add({.digest = digest_of_token("samples"), .rights = AccessRights("alice", {"*"})});
  list->add({.digest = digest_of_token("surfaces"), .rights = meshes_alone});
  const auto permit_of = [&](const std::string& token, const std::vector<PayloadCodec>& codecs) {
    auto permit = Permit::of(token, list, fake_catalogue("head")).value();
    permit.set_codecs(codecs);
    return permit;
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

TEST(Permit, ReturnsCachedShellsOnlyToClientsThatMaySeeSamples) {
  AccessRights meshes_alone("bob", {"*"});
  meshes_alone.allow_surfaces_only();
  auto list = std::make_shared<AccessList>();
  list->add({.digest = digest_of_token("samples"), .rights = AccessRights("alice", {"head"})});
  list->add({.digest = digest_of_token("surfaces"), .rights = meshes_alone});
  const auto catalogue = fake_catalogue("head");
  catalogue->add(std::make_shared<FakeSteps>("foot"));
  catalogue->add(std::make_shared<StepsWithoutShells>("hand"));
  const Permit alice = Permit::of("samples", list, catalogue).value();
  EXPECT_TRUE(alice.may_see_shells("head"));
  EXPECT_FALSE(alice.may_see_shells("foot"));
  const Permit bob = Permit::of("surfaces", list, catalogue).value();
  EXPECT_TRUE(bob.may_see("head"));
  EXPECT_FALSE(bob.may_see_shells("head"));
  const Permit anyone = Permit::of("", nullptr, catalogue).value();
  EXPECT_TRUE(anyone.may_see_shells("head"));
  EXPECT_FALSE(anyone.may_see_shells("hand"));
  EXPECT_FALSE(anyone.may_see_shells("nothing"));
  EXPECT_FALSE(Permit::of("", nullptr, catalogue, {.surfaces_only = true})->may_see_shells("head"));
}

TEST(Permit, RejectsSamplesForSurfacesOnlyTokens) {
  AccessRights meshes_alone("bob", {"*"});
  meshes_alone.allow_surfaces_only();
  auto list = std::make_shared<AccessList>();
  list->add({.digest = digest_of_token("surfaces"), .rights = meshes_alone});
  for (const auto& permit :
       {Permit::of("surfaces", list, fake_catalogue("head")).value(),
        Permit::of("", nullptr, fake_catalogue("head"), {.surfaces_only = true}).value()}) {
    EXPECT_TRUE(permit.accept(testing::open_fake(1, "head")));
    EXPECT_TRUE(permit.accept(Estimate{.dataset = "head"}));
    EXPECT_EQ(
        permit.accept(Probe{.dataset = "head", .probe = {.places = {{0, 0, 0}}}}).error().code,
        ErrorCode::kPermissionDenied);
    const SliceRequest plane{.right = {1, 0, 0}, .down = {0, 1, 0}, .width = 2, .height = 2};
    EXPECT_EQ(permit.accept(Slice{.dataset = "head", .slice = plane}).error().code,
              ErrorCode::kPermissionDenied);
    // What is not permitted is not validated either.
    EXPECT_EQ(permit.accept(Slice{.dataset = "head", .slice = {}}).error().code,
              ErrorCode::kPermissionDenied);
  }
}

TEST(Permit, RejectsFieldsForSurfacesOnlyTokensWithoutColors) {
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
  const auto code_of = [&](const Result<Permit>& permit) {
    const auto accepted = permit->accept(open);
    return accepted ? std::nullopt : std::optional(accepted.error().code);
  };
  const auto catalogue = fake_catalogue("head");
  EXPECT_EQ(code_of(Permit::of("plain", list, catalogue)), ErrorCode::kPermissionDenied);
  EXPECT_EQ(code_of(Permit::of("", nullptr, catalogue, {.surfaces_only = true})),
            ErrorCode::kPermissionDenied);
  EXPECT_EQ(code_of(Permit::of("colored", list, catalogue)), std::nullopt);
  EXPECT_EQ(code_of(Permit::of("all", list, catalogue)), std::nullopt);
  EXPECT_EQ(code_of(Permit::of("", nullptr, catalogue)), std::nullopt);
}

// A gateway has no tokens, but its upstream servers send this client no samples.
TEST(Permit, OffersNoSamplesThatUpstreamServersDoNotSend) {
  auto catalogue = std::make_shared<DatasetCatalogue>();
  EXPECT_TRUE(Permit::of("", nullptr, catalogue)->check_samples());
  catalogue->add(std::make_shared<StepsWithoutShells>("head"));
  auto permit = Permit::of("", nullptr, catalogue).value();
  permit.set_codecs({PayloadCodec::kDracoLattice, PayloadCodec::kSampleShell});
  EXPECT_EQ(permit.codecs(), std::vector{PayloadCodec::kDracoLattice});
  EXPECT_EQ(permit.check_samples().error().code, ErrorCode::kPermissionDenied);
  catalogue->add(std::make_shared<FakeSteps>("foot"));
  EXPECT_TRUE(permit.check_samples());
}

TEST(Permit, RejectsShellPreviewsThatTheDatasetCannotHave) {
  auto permit = Permit::of("", nullptr, fake_catalogue("head")).value();
  permit.set_codecs({PayloadCodec::kDracoLattice, PayloadCodec::kSampleShell});
  OpenStream open = testing::open_fake(1, "head");
  // The grid has 64 steps per side.
  open.resumed_previews = {{.finest_spacing = 64, .shell = quantized_shells(2)}};
  EXPECT_FALSE(permit.accept(open));
  open.resumed_previews = {{.finest_spacing = 32, .shell = quantized_shells(2)}};
  EXPECT_TRUE(permit.accept(open));
  open.request.normal_bits = 8;
  EXPECT_FALSE(permit.accept(open));
}

TEST(Permit, AppliesAReloadedListAtOnce) {
  auto permit = Permit::of("good", list_of("good", "*"), fake_catalogue("head"));
  ASSERT_TRUE(permit);
  EXPECT_FALSE(permit->renew(list_of("other", "*")));
  EXPECT_TRUE(permit->renew(list_of("good", "frog")));
  EXPECT_FALSE(permit->may_see("head"));
}

TEST(Permit, DescribesDatasetsWhileRejectingWork) {
  auto permit = Permit::of("", nullptr, fake_catalogue("head"));
  permit->reject_requests({ErrorCode::kUnavailable, "stopping"});
  EXPECT_TRUE(permit->describe("head"));
  EXPECT_EQ(permit->accept(testing::open_fake(1, "head")).error().code, ErrorCode::kUnavailable);
}

}  // namespace
}  // namespace multitetra
