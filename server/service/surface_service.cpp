#include "server/service/surface_service.hpp"

#include <utility>

#include "server/service/run_on_workers.hpp"
#include "server/service/waiting_bytes.hpp"

namespace multitetra {
namespace {

template <typename Reply>
Result<Reply> the(Result<DatasetQueryReply> reply) {
  if (!reply) return tl::unexpected(reply.error());
  return std::get<Reply>(*std::move(reply));
}

// The surfaces of one request, with the memory that is reserved for them until they were used.
struct HeldSurfaces {
  std::vector<Surface> surfaces = {};
  std::vector<ByteReservations::Reservation> memory = {};
  bool is_above_limit = false;
};

}  // namespace

std::optional<asio::awaitable<Result<CataloguePtr>>> ServiceClient::find_catalogue(
    const std::string& token) {
  if (!ClientAccess::of(token, client_->admission().access(), nullptr)) return std::nullopt;
  return fetch_catalogue(token);
}

asio::awaitable<Result<void>> ServiceClient::log_in(std::string token) {
  const AdmissionControl& admission = client_->admission();
  if (auto finding = find_catalogue(token)) {
    const auto found = co_await *std::move(finding);
    if (!found) co_return tl::unexpected(found.error());
  }
  auto client_access = ClientAccess::of(std::move(token), admission.access(), catalogue(), limits_);
  if (!client_access) co_return tl::unexpected(client_access.error());
  client_access_ = *std::move(client_access);
  if (const auto work = admission.check_draining(); !work)
    client_access_.reject_requests(work.error());
  client_->set_identity(client_access_.rights().name(), client_access_.has_token());
  co_return Result<void>();
}

void ServiceClient::close(std::optional<Error> why) {
  if (!closed_)
    closed_ = why.value_or(Error{ErrorCode::kCancelled, "The client has disconnected."});
  stop_.request_stop();
  when_closed();
}

Error ServiceClient::reason(const Error& error) const {
  return error.code == ErrorCode::kCancelled && closed_ ? *closed_ : error;
}

asio::awaitable<Result<void>> ServiceClient::use_surfaces(SurfacesRequest wanted, std::string what,
                                                          UseSurfaces use) {
  const auto held = std::make_shared<HeldSurfaces>();
  ByteReservations& queue = client_->admission().queue();
  std::uint64_t max_triangles = wanted.max_triangles;
  for (std::size_t i = 0; i < wanted.requests.size(); ++i) {
    const bool is_last = i + 1 == wanted.requests.size();
    OpenStream open{.request_id = request_ + surfaces_++,
                    .dataset = wanted.dataset,
                    .request = std::move(wanted.requests[i]),
                    .steps = StepPolicy::kFinalOnly,
                    .cached_tile_digests = {},
                    .scalars = wanted.scalars};
    const auto waiting = client_->reserve(waiting_bytes(open));
    if (!waiting) co_return tl::unexpected(waiting.error());
    auto action = client_access_.accept(std::move(open));
    if (!action) co_return tl::unexpected(action.error());
    UseSurface add = [held, &queue, share = client_->quota_key(),
                      use = is_last ? use : UseSurfaces()](
                         Surface surface, const std::stop_token& stop) -> Result<void> {
      auto memory = queue.take(share, bytes_of(surface.mesh));
      held->is_above_limit = !memory;
      if (!memory) return fail(ErrorCode::kUnavailable, "There is not enough memory.");
      held->memory.push_back(*std::move(memory));
      held->surfaces.push_back(std::move(surface));
      if (!use) return {};
      const auto in_use = std::exchange(held->memory, {});
      return use(std::exchange(held->surfaces, {}), stop);
    };
    std::function<void(std::function<void(Result<void>)>)> start =
        [&](std::function<void(Result<void>)> done) {
          make_surface(*std::move(action), max_triangles, is_last ? what : "surface",
                       stop_.get_token(), std::move(add), std::move(done));
        };
    const auto made = co_await result_of<void>(std::move(start));
    // A reservation that is refused is reported here, on the executor's thread.
    if (held->is_above_limit) {
      co_return tl::unexpected(client_->reserve(queue.capacity() + 1).error());
    }
    if (!made) co_return tl::unexpected(reason(made.error()));
    if (!is_last) max_triangles -= held->surfaces.back().mesh.triangles.size();
  }
  co_return Result<void>();
}

asio::awaitable<Result<DatasetQueryReply>> ServiceClient::run_query(DatasetQuery query,
                                                                    UseReply use) {
  const auto waiting = client_->reserve(waiting_bytes(query));
  if (!waiting) co_return tl::unexpected(waiting.error());
  auto action = client_access_.accept(std::move(query));
  if (!action) co_return tl::unexpected(action.error());
  std::function<void(QueryDone)> start = [&](QueryDone done) {
    answer(*std::move(action), stop_.get_token(), std::move(use), std::move(done));
  };
  auto made = co_await result_of<DatasetQueryReply>(std::move(start));
  if (!made) co_return tl::unexpected(reason(made.error()));
  co_return made;
}

asio::awaitable<Result<EstimateReply>> ServiceClient::estimate(std::string dataset,
                                                               IsosurfaceRequest request) {
  DatasetQuery query = Estimate{
      .request_id = request_, .dataset = std::move(dataset), .request = std::move(request)};
  co_return the<EstimateReply>(co_await run_query(std::move(query)));
}

asio::awaitable<Result<SliceReply>> ServiceClient::slice(std::string dataset, SliceRequest slice,
                                                         UseReply use) {
  DatasetQuery query = Slice{.request_id = request_, .dataset = std::move(dataset), .slice = slice};
  co_return the<SliceReply>(co_await run_query(std::move(query), std::move(use)));
}

asio::awaitable<Result<ProbeReply>> ServiceClient::probe(std::string dataset, ProbeRequest probe) {
  DatasetQuery query =
      Probe{.request_id = request_, .dataset = std::move(dataset), .probe = std::move(probe)};
  co_return the<ProbeReply>(co_await run_query(std::move(query)));
}

ServiceState state_of(const TileCache& tiles) {
  const TileCache::Counts counts = tiles.counts();
  return {.cache_hits = counts.hits,
          .cache_misses = counts.misses,
          .cached_tiles = counts.tiles,
          .cache_bytes = counts.bytes};
}

}  // namespace multitetra
