// Checks what a client may request with its token: which datasets it may see, and which requests
// for them are valid. Every transport checks tokens and requests here, and only here. Pure.
//
//   const auto client_access = ClientAccess::of(token, admission.access(), catalogue);
//   auto job = client_access->accept(OpenStream{.dataset = "head", ...});
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

// A validated stream request.
struct ValidatedStream {
  OpenStream open;
  SurfaceProviderPtr source;
  // The provider of open.scalars; null without scalars.
  SurfaceProviderPtr scalars = nullptr;
  // Steps may be sent as sample shells.
  bool shells = false;
  // The providers of open.further_datasets.
  std::vector<SurfaceProviderPtr> further = {};
};
// A validated query.
struct ValidatedQuery {
  DatasetQuery query;
  SurfaceProviderPtr source;
};

// A part of the list of datasets, in natural order of names. Valid while the catalogue lives.
struct DatasetPage {
  std::vector<const DatasetCatalogue::Entry*> datasets;
  std::string next;  // The last name of the page; empty if no more datasets follow.
};
struct PageLimits {
  std::size_t datasets = 1024;
  std::size_t bytes = 1 << 20;  // Encoded. A page has at least one dataset.
};

// Request limits that are stricter than those of the protocol.
struct RequestLimits {
  std::size_t max_regions = kMaxThresholdRegions;
  // Rejects requests whose replies hold samples.
  bool surfaces_only = false;
};

class ClientAccess {
 public:
  // Allows nothing; all datasets are hidden.
  ClientAccess() = default;

  // Returns kUnauthenticated if the list does not contain the token. Without a list, all datasets
  // are visible.
  [[nodiscard]] static Result<ClientAccess> of(std::string token, AccessListPtr access,
                                               CataloguePtr catalogue, RequestLimits limits = {});

  // Replaces the access list. Fails if it does not contain the token.
  [[nodiscard]] Result<void> renew(AccessListPtr access);
  void offer(CataloguePtr catalogue) { catalogue_ = std::move(catalogue); }
  // Sets the codecs that the client decodes; initially Draco only.
  void set_codecs(const std::vector<PayloadCodec>& codecs);
  // Returns the codecs that payloads for this client may have.
  [[nodiscard]] std::vector<PayloadCodec> codecs() const;
  // Rejects all further streams and queries with this error.
  void reject_requests(Error why) { rejection_ = std::move(why); }

  [[nodiscard]] const AccessListPtr& access() const { return access_; }
  [[nodiscard]] const AccessRights& rights() const { return rights_; }
  // Returns whether the rights come from a token that the client presented.
  [[nodiscard]] bool has_token() const { return access_ && !token_.empty(); }
  // Returns whether all clients have the same access.
  [[nodiscard]] bool is_for_all() const { return !access_ && token_.empty(); }
  [[nodiscard]] bool may_see(const std::string& dataset) const;
  // Returns whether tiles of the dataset may be sent as sample shells.
  [[nodiscard]] bool may_see_shells(const std::string& dataset) const;

  // Returns kPermissionDenied if this client may receive surfaces only, and no samples.
  [[nodiscard]] Result<void> check_samples() const;

  // Returns the datasets visible to this client whose names follow `after`.
  [[nodiscard]] DatasetPage list(std::string_view after = {}, const PageLimits& limits = {}) const;
  // Returns the datasets visible to this client whose volumes are being read.
  [[nodiscard]] std::vector<DatasetReading> readings() const;
  // Returns one of the datasets, else kUnknownDataset, or kUnavailable while its volume is read.
  [[nodiscard]] Result<DatasetInfo> describe(const std::string& dataset) const;

  [[nodiscard]] Result<ValidatedStream> accept(OpenStream open) const;
  [[nodiscard]] Result<ValidatedQuery> accept(DatasetQuery query) const;

 private:
  [[nodiscard]] Result<SurfaceProviderPtr> find(const std::string& dataset) const;
  // Returns visible names near `name` in natural order.
  [[nodiscard]] std::vector<std::string> names_near(const std::string& name) const;
  // Returns the provider of a visible dataset, unless work is refused.
  [[nodiscard]] Result<SurfaceProviderPtr> provider(const std::string& dataset) const;
  // Returns the same if the dataset can also serve a valid `request`.
  [[nodiscard]] Result<SurfaceProviderPtr> provider(const std::string& dataset,
                                                    const IsosurfaceRequest& request) const;
  // A gateway learns from its upstream servers that a client gets surfaces only.
  [[nodiscard]] bool is_for_surfaces_only() const {
    return limits_.surfaces_only || rights_.surfaces_only() ||
           (catalogue_ && catalogue_->is_for_surfaces_only());
  }
  // Returns the further datasets of a request for previews of several.
  [[nodiscard]] Result<std::vector<SurfaceProviderPtr>> further_datasets(
      const OpenStream& open, const DatasetInfo& first) const;
  // Returns the provider of the field that colors a surface, or kPermissionDenied if colors would
  // reveal samples to a client that may not see them.
  [[nodiscard]] Result<SurfaceProviderPtr> field_for(const ScalarRequest& scalars,
                                                     const DatasetInfo& surface) const;

  CataloguePtr catalogue_;
  RequestLimits limits_;
  AccessListPtr access_;
  std::string token_;
  AccessRights rights_;
  std::optional<Error> rejection_;
  bool decodes_shells_ = false;
};

}  // namespace multitetra
