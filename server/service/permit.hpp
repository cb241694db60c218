// Checks what a client may request with its token: the datasets that exist for it, and which
// requests for them are valid. Every transport checks tokens and requests here, and nowhere else.
// Pure.
//
//   const auto permit = Permit::of(token, admission.access(), catalogue);
//   auto job = permit->accept(OpenStream{.dataset = "head", ...});
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/wire/messages.hpp"
#include "server/operations/access_list.hpp"
#include "server/service/dataset_catalogue.hpp"
#include "server/service/dataset_queries.hpp"

namespace multitetra {

using SurfaceProviderPtr = std::shared_ptr<const SurfaceProvider>;

// A stream whose request was found good.
struct StartStream {
  OpenStream open;
  SurfaceProviderPtr source;
  // The provider of open.scalars; null without scalars.
  SurfaceProviderPtr scalars = nullptr;
  bool shells = false;  // Its steps may have them.
};
// A query that was found good.
struct RunQuery {
  DatasetQuery query;
  SurfaceProviderPtr source;
};

// Limits of requests that are stricter than those of the protocol.
struct RequestLimits {
  std::size_t max_regions = kMaxThresholdRegions;
  bool surfaces_only = false;  // Nothing that holds samples, for anyone.
};

class Permit {
 public:
  Permit() = default;  // Allows nothing: no dataset exists.

  // kUnauthenticated where the list does not contain the token. Without a list all datasets are
  // visible.
  [[nodiscard]] static Result<Permit> of(std::string token, AccessListPtr access,
                                         CataloguePtr catalogue, RequestLimits limits = {});

  // Another list holds from now on: an error where it does not know the token.
  [[nodiscard]] Result<void> renew(AccessListPtr access);
  void offer(CataloguePtr catalogue) { catalogue_ = std::move(catalogue); }
  // Sets the codecs that the client decodes; Draco, unless this is called.
  void decodes(const std::vector<PayloadCodec>& codecs);
  // Those that its payloads may have.
  [[nodiscard]] std::vector<PayloadCodec> codecs() const;
  // From now on nothing is accepted, with this error.
  void refuse_work(Error why) { no_work_ = std::move(why); }

  [[nodiscard]] const AccessListPtr& access() const { return access_; }
  [[nodiscard]] const AccessRights& rights() const { return rights_; }
  // Whether those are the rights of a token that was shown.
  [[nodiscard]] bool has_token() const { return access_ && !token_.empty(); }
  // Whether all clients have the same permit.
  [[nodiscard]] bool is_for_all() const { return !access_ && token_.empty(); }
  [[nodiscard]] bool may_see(const std::string& dataset) const;
  // Whether it may also have tiles of the dataset that hold samples.
  [[nodiscard]] bool may_see_shells(const std::string& dataset) const;

  // The datasets that there are for this client, by name; one of them, or kUnknownDataset.
  [[nodiscard]] std::vector<DatasetInfo> describe() const;
  [[nodiscard]] Result<DatasetInfo> describe(const std::string& dataset) const;

  [[nodiscard]] Result<StartStream> accept(OpenStream open) const;
  [[nodiscard]] Result<RunQuery> accept(DatasetQuery query) const;

 private:
  [[nodiscard]] Result<SurfaceProviderPtr> find(const std::string& dataset) const;
  // The provider of a visible dataset.
  [[nodiscard]] Result<SurfaceProviderPtr> provider(const std::string& dataset) const;
  // The same where a valid request for it can be met.
  [[nodiscard]] Result<SurfaceProviderPtr> provider(const std::string& dataset,
                                                    const IsosurfaceRequest& request) const;
  [[nodiscard]] bool is_for_surfaces_only() const {
    return limits_.surfaces_only || rights_.surfaces_only();
  }
  // The field that shall color a surface.
  [[nodiscard]] Result<SurfaceProviderPtr> field_for(const ScalarRequest& scalars,
                                                     const DatasetInfo& surface) const;

  CataloguePtr catalogue_;
  RequestLimits limits_;
  AccessListPtr access_;
  std::string token_;
  AccessRights rights_;
  std::optional<Error> no_work_;
  bool decodes_shells_ = false;
};

}  // namespace multitetra
