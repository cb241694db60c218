#include "server/service/client_access.hpp"

#include <algorithm>
#include <utility>

#include "common/base/nearest_word.hpp"
#include "common/request/lattice_limit.hpp"
#include "server/core/planning/shell_steps.hpp"

namespace multitetra {
namespace {

// Rejects previews that no stream of this dataset can have begun with.
Result<void> check_begun(const OpenStream& open, const DatasetInfo& info, bool shells) {
  const std::vector<Preview>& begun = open.resumed_previews;
  if (!begun.empty() && begun.front().finest_spacing > 1 << info.grid_exponent) {
    return fail(ErrorCode::kInvalidArgument,
                "OpenStream.resumed_previews has a preview with a finest spacing of " +
                    std::to_string(begun.front().finest_spacing) + "; dataset \"" + info.name +
                    "\" has a grid of " + std::to_string(1 << info.grid_exponent) +
                    " steps a side.");
  }
  for (const Preview& preview : begun) {
    if (!preview.shell) continue;
    const bool is_possible = shells && allows_shells(open.request) &&
                             has_shells(info, level_of(preview_step(open.request, preview, info)));
    if (is_possible) continue;
    return fail(ErrorCode::kInvalidArgument,
                "OpenStream.resumed_previews has sample shells that are not possible for this "
                "client, this request or dataset \"" +
                    info.name + "\"; omit them.");
  }
  return {};
}

// Returns whether the clients' checks for the first dataset hold for the other, too.
bool can_share_a_stream(const DatasetInfo& first, const DatasetInfo& other) {
  return other.dims == first.dims && other.spacing == first.spacing &&
         other.index_to_world == first.index_to_world && other.margin == first.margin &&
         other.grid_exponent == first.grid_exponent && other.type == first.type &&
         other.outside == first.outside && (other.void_samples > 0) == (first.void_samples > 0);
}

Result<void> check_limits(const RequestLimits& limits, const IsosurfaceRequest& request) {
  const std::size_t regions = request.thresholds.regions.size();
  if (regions <= limits.max_regions) return {};
  return fail(ErrorCode::kLimitExceeded, "The threshold map has " + std::to_string(regions) +
                                             " regions; this server allows " +
                                             std::to_string(limits.max_regions) + ".");
}

Result<void> check(const DatasetQuery& query) {
  if (const auto* estimate = std::get_if<Estimate>(&query)) {
    if (const auto valid = validated(estimate->request); !valid) {
      return tl::unexpected(valid.error());
    }
  } else if (const auto* slice = std::get_if<Slice>(&query)) {
    if (const auto valid = validated(slice->slice); !valid) return tl::unexpected(valid.error());
  } else if (const auto valid = validated(std::get<Probe>(query).probe); !valid) {
    return tl::unexpected(valid.error());
  }
  return {};
}

// Refuses a request for a dataset that was replaced; notes the one that is meant, for servers
// behind a gateway.
Result<void> settle_content(std::uint64_t& content_id, const DatasetInfo& info) {
  if (content_id != 0 && content_id != info.content_id) {
    return fail(ErrorCode::kUnavailable, "\"" + info.name +
                                             "\" was replaced since this client listed it; list "
                                             "the datasets again.");
  }
  content_id = info.content_id;
  return {};
}

}  // namespace

Result<ClientAccess> ClientAccess::of(std::string token, AccessListPtr access,
                                      CataloguePtr catalogue, RequestLimits limits) {
  ClientAccess client_access;
  client_access.token_ = std::move(token);
  client_access.catalogue_ = std::move(catalogue);
  client_access.limits_ = limits;
  if (const auto known = client_access.renew(std::move(access)); !known) {
    return tl::unexpected(known.error());
  }
  return client_access;
}

Result<void> ClientAccess::renew(AccessListPtr access) {
  access_ = std::move(access);
  if (!access_) {
    rights_ = {};
    return {};
  }
  auto rights = access_->rights_of(token_);
  if (!rights) return tl::unexpected(rights.error());
  rights_ = *std::move(rights);
  return {};
}

void ClientAccess::set_codecs(const std::vector<PayloadCodec>& codecs) {
  decodes_shells_ = std::count(codecs.begin(), codecs.end(), PayloadCodec::kSampleShell) > 0;
}

std::vector<PayloadCodec> ClientAccess::codecs() const {
  std::vector<PayloadCodec> codecs = {PayloadCodec::kDracoLattice};
  if (decodes_shells_ && !is_for_surfaces_only()) codecs.push_back(PayloadCodec::kSampleShell);
  return codecs;
}

// A hidden dataset gets the same error as a missing one, and is never suggested as a correction.
Result<SurfaceProviderPtr> ClientAccess::find(const std::string& dataset) const {
  if (catalogue_ && rights_.may_see(dataset)) {
    if (SurfaceProviderPtr found = catalogue_->find(dataset)) return found;
  }
  for (const DatasetReading& reading : readings()) {
    if (reading.name != dataset) continue;
    const std::string share = std::to_string(static_cast<int>(100 * reading.share));
    return tl::unexpected(Error{.code = ErrorCode::kUnavailable,
                                .text = "Dataset \"" + dataset +
                                        "\" can be used when its volume has been read; " + share +
                                        " % are.",
                                .retry_after = 1});
  }
  return fail(ErrorCode::kUnknownDataset,
              "No dataset is named \"" + dataset +
                  "\"; see the list of datasets (multitetra-client list, /v1/datasets)." +
                  did_you_mean(dataset, names_near(dataset)));
}

// Bounded, as the names are compared on the network's thread.
std::vector<std::string> ClientAccess::names_near(const std::string& name) const {
  constexpr int kEachWay = 256;
  std::vector<std::string> names;
  if (!catalogue_) return names;
  const DatasetCatalogue::Entries& entries = catalogue_->entries();
  const auto add = [&](const std::string& one) {
    if (rights_.may_see(one)) names.push_back(one);
  };
  const auto middle = entries.lower_bound(name);
  auto after = middle;
  for (int i = 0; i < kEachWay && after != entries.end(); ++i, ++after) add(after->first);
  auto before = middle;
  for (int i = 0; i < kEachWay && before != entries.begin(); ++i) add((--before)->first);
  return names;
}

bool ClientAccess::may_see(const std::string& dataset) const {
  return catalogue_ && rights_.may_see(dataset) && catalogue_->find(dataset);
}

bool ClientAccess::may_see_shells(const std::string& dataset) const {
  return !is_for_surfaces_only() && may_see(dataset) && catalogue_->find(dataset)->sends_shells();
}

DatasetPage ClientAccess::list(std::string_view after, const PageLimits& limits) const {
  DatasetPage page;
  if (!catalogue_) return page;
  const DatasetCatalogue::Entries& entries = catalogue_->entries();
  std::size_t bytes = 0;
  const std::string* last = nullptr;
  for (auto at = entries.upper_bound(after); at != entries.end(); ++at) {
    const auto& [name, entry] = *at;
    if (!rights_.may_see(name)) continue;
    bytes += entry.encoded->size();
    const bool is_full = page.datasets.size() >= limits.datasets || bytes > limits.bytes;
    if (is_full && last) {
      page.next = *last;  // Never a hidden name.
      break;
    }
    page.datasets.push_back(&entry);
    last = &name;
  }
  return page;
}

std::vector<DatasetReading> ClientAccess::readings() const {
  if (!catalogue_) return {};
  std::vector<DatasetReading> readings = catalogue_->readings();
  std::erase_if(readings, [&](const DatasetReading& one) { return !rights_.may_see(one.name); });
  return readings;
}

Result<DatasetInfo> ClientAccess::describe(const std::string& dataset) const {
  const auto found = find(dataset);
  if (!found) return tl::unexpected(found.error());
  return (*found)->info();
}

Result<SurfaceProviderPtr> ClientAccess::provider(const std::string& dataset) const {
  if (rejection_) return tl::unexpected(*rejection_);
  return find(dataset);
}

Result<SurfaceProviderPtr> ClientAccess::provider(const std::string& dataset,
                                                  const IsosurfaceRequest& request) const {
  if (const auto checked = check_limits(limits_, request); !checked) {
    return tl::unexpected(checked.error());
  }
  auto source = provider(dataset);
  if (!source) return source;
  if (const auto checked = check_lattice(request, (*source)->info()); !checked) {
    return tl::unexpected(checked.error());
  }
  if (request.cell) {
    if (const auto checked = check_cell(*request.cell, (*source)->info()); !checked) {
      return tl::unexpected(checked.error());
    }
  }
  return source;
}

Result<SurfaceProviderPtr> ClientAccess::field_for(const ScalarRequest& scalars,
                                                   const DatasetInfo& surface) const {
  if (is_for_surfaces_only() && !(rights_.surfaces_only() && rights_.colors())) {
    return fail(ErrorCode::kPermissionDenied,
                "Colors by a field show its samples; this client has access to surfaces only.");
  }
  if (const auto valid = validated(scalars); !valid) return tl::unexpected(valid.error());
  auto field = provider(scalars.dataset);
  if (!field) return field;
  if (const auto checked = check_same_world(scalars, surface, (*field)->info()); !checked) {
    return tl::unexpected(checked.error());
  }
  return field;
}

Result<std::vector<SurfaceProviderPtr>> ClientAccess::further_datasets(
    const OpenStream& open, const DatasetInfo& first) const {
  std::vector<SurfaceProviderPtr> further;
  further.reserve(open.further_datasets.size());
  for (const std::string& name : open.further_datasets) {
    auto source = provider(name);
    if (!source) return tl::unexpected(source.error());
    const DatasetInfo& info = (*source)->info();
    if (!can_share_a_stream(first, info)) {
      return fail(ErrorCode::kInvalidArgument,
                  "Datasets \"" + first.name + "\" and \"" + name +
                      "\" differ in their grid, sample type or value outside, or one has samples "
                      "without a value; request the previews of one of them in a stream of its "
                      "own.");
    }
    further.push_back(*std::move(source));
  }
  return further;
}

Result<ValidatedStream> ClientAccess::accept(OpenStream open) const {
  if (const auto valid = validated(open.request); !valid) return tl::unexpected(valid.error());
  auto source = provider(open.dataset, open.request);
  if (!source) return tl::unexpected(source.error());
  const DatasetInfo& info = (*source)->info();
  if (const auto same = settle_content(open.content_id, info); !same) {
    return tl::unexpected(same.error());
  }
  const bool shells = decodes_shells_ && !is_for_surfaces_only() && !open.scalars;
  if (const auto checked = check_begun(open, info, shells); !checked) {
    return tl::unexpected(checked.error());
  }
  auto further = further_datasets(open, info);
  if (!further) return tl::unexpected(further.error());
  SurfaceProviderPtr scalars;
  if (open.scalars) {
    auto field = field_for(*open.scalars, info);
    if (!field) return tl::unexpected(field.error());
    scalars = *std::move(field);
  }
  return ValidatedStream{.open = std::move(open),
                         .source = *std::move(source),
                         .scalars = std::move(scalars),
                         .shells = shells,
                         .further = *std::move(further)};
}

Result<void> ClientAccess::check_samples() const {
  if (!is_for_surfaces_only()) return {};
  return fail(ErrorCode::kPermissionDenied,
              "Slices and probes show samples; this client has access to surfaces only.");
}

Result<ValidatedQuery> ClientAccess::accept(DatasetQuery query) const {
  if (!std::holds_alternative<Estimate>(query)) {
    if (const auto allowed = check_samples(); !allowed) return tl::unexpected(allowed.error());
  }
  if (const auto checked = check(query); !checked) return tl::unexpected(checked.error());
  const IsosurfaceRequest* request = request_of(query);
  auto source = request ? provider(dataset_of(query), *request) : provider(dataset_of(query));
  if (!source) return tl::unexpected(source.error());
  const auto same = std::visit(
      [&](auto& one) { return settle_content(one.content_id, (*source)->info()); }, query);
  if (!same) return tl::unexpected(same.error());
  return ValidatedQuery{.query = std::move(query), .source = *std::move(source)};
}

}  // namespace multitetra
