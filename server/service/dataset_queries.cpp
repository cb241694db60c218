#include "server/service/dataset_queries.hpp"

#include <algorithm>
#include <utility>

#include "common/base/in_parallel.hpp"
#include "server/core/planning/budget.hpp"
#include "server/core/sampling/field_probe.hpp"
#include "server/core/thresholds/threshold_map.hpp"
#include "server/extraction/packed_values.hpp"
#include "server/extraction/sampled_slice.hpp"
#include "server/stream/stream_plan.hpp"

namespace multitetra {
namespace {

// Rounds an estimate to the integer that a reply holds.
std::uint64_t rounded(double value) {
  return static_cast<std::uint64_t>(std::min(value, 1e18) + 0.5);
}

// Fails with an internal error for a source without samples.
Result<const PreparedVolume*> volume_of(const SurfaceProvider& source) {
  if (const PreparedVolume* volume = source.volume()) return volume;
  return fail(ErrorCode::kInternal, "This server does not have samples of the dataset.");
}

Result<DatasetQueryReply> answer(const SurfaceProvider& source, const Estimate& query,
                                 const std::stop_token& stop) {
  const auto found = estimate(source, query.request, stop);
  if (!found) return tl::unexpected(found.error());
  return EstimateReply{.request_id = query.request_id,
                       .triangles = rounded(found->size.triangles),
                       .bytes = rounded(found->size.bytes),
                       .error_bound_world = largest_threshold(found->request, source.info())};
}

Result<DatasetQueryReply> answer(const SurfaceProvider& source, const Slice& query,
                                 const std::stop_token& stop) {
  const auto volume = volume_of(source);
  if (!volume) return tl::unexpected(volume.error());
  const auto sampled = sampled_slice(**volume, query.slice, stop);
  if (!sampled) return tl::unexpected(sampled.error());
  SliceReply reply{.request_id = query.request_id,
                   .width = query.slice.width,
                   .height = query.slice.height,
                   .layers = query.slice.layers,
                   .sample_spacing = static_cast<std::uint32_t>(sampled->spacing)};
  if (query.slice.accepts_packed) {
    PackedValues packed = packed_values(sampled->values, source.info().type);
    reply.packed_type = packed.type;
    reply.values = std::make_shared<const std::string>(std::move(packed.bytes));
  } else {
    const auto* const bytes = reinterpret_cast<const char*>(sampled->values.data());
    reply.values =
        std::make_shared<const std::string>(bytes, sampled->values.size() * sizeof(float));
  }
  return reply;
}

Result<DatasetQueryReply> answer(const SurfaceProvider& source, const Probe& query,
                                 const std::stop_token& stop) {
  const auto volume = volume_of(source);
  if (!volume) return tl::unexpected(volume.error());
  ProbeReply reply{.request_id = query.request_id, .places = {}};
  for (const Vec3& place : query.probe.places) {
    throw_if_stopped(stop);
    reply.places.push_back(probed(**volume, query.probe.coordinates, place));
  }
  if ((*volume)->check) (*volume)->check();
  return reply;
}

}  // namespace

std::uint64_t request_id_of(const DatasetQuery& query) {
  return std::visit([](const auto& one) { return one.request_id; }, query);
}

const std::string& dataset_of(const DatasetQuery& query) {
  return std::visit([](const auto& one) -> const std::string& { return one.dataset; }, query);
}

Priority priority_of(const DatasetQuery& query) {
  if (const auto* one = std::get_if<Estimate>(&query)) return one->priority;
  if (const auto* one = std::get_if<Slice>(&query)) return one->priority;
  return Priority::kNormal;
}

const char* kind_of(const DatasetQuery& query) {
  if (std::holds_alternative<Estimate>(query)) return "estimate";
  return std::holds_alternative<Slice>(query) ? "slice" : "probe";
}

const IsosurfaceRequest* request_of(const DatasetQuery& query) {
  const auto* one = std::get_if<Estimate>(&query);
  return one ? &one->request : nullptr;
}

// A budget search takes as long as several steps, and so does simplifying a sample of the surface.
bool is_long(const DatasetQuery& query) {
  const IsosurfaceRequest* request = request_of(query);
  return request && (has_budget(*request) || request->simplify);
}

Result<DatasetQueryReply> answered(const SurfaceProvider& source, const DatasetQuery& query,
                                   const std::stop_token& stop) {
  return std::visit([&](const auto& one) { return answer(source, one, stop); }, query);
}

}  // namespace multitetra
