#include "server/service/waiting_bytes.hpp"

#include <variant>

namespace multitetra {
namespace {

// The session, service and log records of any request.
constexpr std::size_t kBytesPerRequest = 4096;
constexpr std::size_t kBytesPerHeldTile = 64;  // A set entry.
constexpr std::size_t kOfADataset = 64;        // Its name and provider.

std::size_t bytes_of(const IsosurfaceRequest& request) {
  // One in the stream, and one in its next step.
  constexpr std::size_t kCopies = 2;
  const LocalThresholds& thresholds = request.thresholds;
  const std::size_t grid =
      thresholds.grid ? thresholds.grid->thresholds.size() * sizeof(float) : std::size_t{0};
  return kCopies * thresholds.regions.size() * sizeof(ThresholdRegion) + grid;
}

std::size_t bytes_of(const SliceRequest& slice) { return slice.pixels() * sizeof(float); }

std::size_t bytes_of(const DatasetInfo& info) {
  return sizeof info + info.name.size() + info.histogram.counts.size() * sizeof(std::uint64_t) +
         info.suggested_isovalues.size() * sizeof(double);
}

}  // namespace

std::size_t waiting_bytes(const OpenStream& open) {
  std::size_t bytes = kBytesPerRequest + bytes_of(open.request) +
                      open.cached_tile_digests.size() * kBytesPerHeldTile +
                      open.resumed_previews.size() * sizeof(Preview);
  for (const std::string& dataset : open.further_datasets) bytes += kOfADataset + dataset.size();
  return bytes;
}

std::size_t waiting_bytes(const DatasetQuery& query) {
  if (const auto* estimate = std::get_if<Estimate>(&query)) {
    return kBytesPerRequest + bytes_of(estimate->request);
  }
  if (const auto* probe = std::get_if<Probe>(&query)) {
    return kBytesPerRequest + probe->probe.places.size() * (sizeof(Vec3) + sizeof(ProbedPlace));
  }
  // One copy as samples, and one in the reply.
  return kBytesPerRequest + 2 * bytes_of(std::get<Slice>(query).slice);
}

std::size_t waiting_bytes(const ServerMessage& message) {
  const auto* list = std::get_if<DatasetList>(&message);
  if (list == nullptr) return 0;
  std::size_t bytes = 0;
  for (const DatasetInfo& info : list->datasets) bytes += 2 * bytes_of(info);  // And encoded.
  for (const auto& dataset : list->encoded) bytes += dataset->size();  // One copy, the message.
  return bytes;
}

}  // namespace multitetra
