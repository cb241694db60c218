#include "server/http/surface_service.hpp"

#include <new>
#include <utility>

#include "common/base/number_text.hpp"
#include "common/request/request_key.hpp"
#include "common/request/shared_budget.hpp"
#include "server/http/conditions.hpp"
#include "server/http/media.hpp"
#include "server/http/on_workers.hpp"
#include "server/operations/log.hpp"

namespace multitetra {
namespace {

// Of what this program makes of a request: to be raised when the same request gives other bytes.
constexpr std::string_view kFormVersion = "3";

// Of a mesh that takes its time.
constexpr std::uint64_t kManyTriangles = 200'000;

// Of all tiles together.
std::uint64_t bytes_of(const StepBegin& step) {
  std::uint64_t sum = 0;
  for (const TileSummary& tile : step.tiles) sum += tile.bytes;
  return sum;
}

Result<StoredMesh> guarded_store(const std::vector<OneShotSession::Step>& steps,
                                 const DatasetInfo& info, const MeshForm& form,
                                 const MeshPlace& place, const std::stop_token& stop) {
  try {
    return store_mesh(steps, info, form, place, stop);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kLimitExceeded,
                "The server has not enough memory for this mesh in one response; allow a larger "
                "error, or take it as a stream.");
  } catch (const std::exception& trouble) {
    log_line(LogLevel::kError, std::string("making a mesh file failed: ") + trouble.what(),
             {{"dataset", info.name}});
    return fail(ErrorCode::kInternal,
                "The server failed to make this mesh's file; its log says why.");
  }
}

}  // namespace

SurfaceService::SurfaceService(const HttpOptions& options)
    : options_(options), meshes_(options.mesh_cache_bytes) {}

asio::awaitable<Result<SurfaceService::Wanted>> SurfaceService::wanted(const std::string& dataset,
                                                                       const Target& target,
                                                                       const HttpRequest& request,
                                                                       OneShotSession& one_shot) {
  const auto query = parse_surface_query(target.query);
  if (!query) co_return tl::unexpected(query.error());
  auto info = co_await one_shot.dataset(dataset);
  if (!info) co_return tl::unexpected(info.error());
  auto surfaces = requests_for(*query, *info);
  if (!surfaces) co_return tl::unexpected(surfaces.error());
  auto scalars = scalars_for(*query);
  if (!scalars) co_return tl::unexpected(scalars.error());
  const auto format =
      query->format ? query->format : accepted_format(field(request, http::field::accept));
  if (!format) {
    co_return fail(ErrorCode::kUnsupportedVersion,
                   "A mesh comes as model/gltf-binary, application/ply, model/stl, model/obj, "
                   "application/vnd.draco or application/vnd.vtk.polydata+xml, and the request "
                   "accepts none of them.");
  }
  if (surfaces->size() > 1 && *format != MeshFormat::kGlb) {
    co_return fail(ErrorCode::kInvalidArgument,
                   "Several surfaces come in one file as format=glb alone; ask for one at a time.");
  }
  Wanted wanted{.info = std::move(*info),
                .requests = *std::move(surfaces),
                .scalars = *std::move(scalars),
                .form = {.format = *format,
                         .is_in_world = query->is_in_world,
                         .colors = query->colors,
                         .min_component = query->min_component},
                .is_format_negotiated = !query->format,
                .key = {},
                .tag = {}};
  wanted.key = std::string(kFormVersion) + ' ' + std::string(media_type(*format)) +
               (query->is_in_world ? " w " : " i ") + key_of(wanted.info);
  if (query->min_component > 0) wanted.key += " from " + shortest_text(query->min_component);
  for (const IsosurfaceRequest& one : wanted.requests) wanted.key += ' ' + key_of(one);
  bool is_told = wanted.info.content_id != 0;
  if (wanted.scalars) {
    const auto field = co_await one_shot.dataset(wanted.scalars->dataset);
    if (!field) co_return tl::unexpected(field.error());
    const ScalarRange range = range_for(*wanted.scalars, *field);
    const ColorScale& colors = wanted.form.colors;
    wanted.key += " colours " + std::string(name(colors.map)) + ' ' + shortest_text(range.low) +
                  ' ' + shortest_text(range.high) + (colors.is_logarithmic ? " log" : "");
    for (const std::uint8_t part : colors.no_value) wanted.key += ' ' + std::to_string(part);
    wanted.key += ' ' + key_of(*field);
    is_told = is_told && field->content_id != 0;
  }
  if (is_told) wanted.tag = tag_of(wanted.key);
  co_return wanted;
}

asio::awaitable<Result<std::vector<OneShotSession::Step>>> SurfaceService::steps_of(
    const Wanted& wanted, OneShotSession& one_shot) {
  std::vector<IsosurfaceRequest> requests = wanted.requests;
  if (must_share(requests)) {
    std::vector<EstimatedSize> sizes;
    for (IsosurfaceRequest request : requests) {
      request.max_triangles = request.max_bytes = 0;
      const auto size = co_await one_shot.estimate(wanted.info.name, std::move(request));
      if (!size) co_return tl::unexpected(size.error());
      sizes.push_back({.triangles = size->triangles, .bytes = size->bytes});
    }
    share_budget(requests, sizes);
  }
  std::vector<OneShotSession::Step> steps;
  std::uint64_t left = options_.max_mesh_triangles;
  for (IsosurfaceRequest& request : requests) {
    auto step =
        co_await one_shot.final_step(wanted.info.name, std::move(request), left, wanted.scalars);
    if (!step) co_return tl::unexpected(step.error());
    left -= triangles_of(step->begin);
    steps.push_back(*std::move(step));
  }
  co_return steps;
}

asio::awaitable<Result<StoredMesh>> SurfaceService::make(const Wanted& wanted,
                                                         OneShotSession& one_shot,
                                                         RequestContext& context) {
  context.stop = std::stop_source();
  if (context.watch) context.watch();
  auto steps = co_await steps_of(wanted, one_shot);
  if (!steps) co_return tl::unexpected(steps.error());
  std::uint64_t payload_bytes = 0;
  std::uint64_t triangles = 0;
  for (const OneShotSession::Step& step : *steps) {
    payload_bytes += bytes_of(step.begin);
    triangles += triangles_of(step.begin);
  }
  const auto waiting = context.client->take_room(payload_bytes);
  if (!waiting) co_return tl::unexpected(waiting.error());
  const std::string share = context.client->share();
  const MeshPlace place = {
      .folder = options_.temporary_folder,
      .room = [this, share](std::uint64_t bytes) { return meshes_.room(share, bytes); }};
  const bool is_large = triangles > kManyTriangles;
  std::function<Result<StoredMesh>()> store =
      [steps = std::make_shared<const std::vector<OneShotSession::Step>>(*std::move(steps)),
       info = wanted.info, form = wanted.form, place,
       stop = context.stop.get_token()] { return guarded_store(*steps, info, form, place, stop); };
  auto stored = co_await on_workers<StoredMesh>(
      assembling_, share, is_large ? "large mesh" : "small mesh", is_large, std::move(store));
  if (stored && !wanted.tag.empty()) meshes_.keep(wanted.key, *stored);
  co_return stored;
}

asio::awaitable<Answer> SurfaceService::answer(const std::string& dataset, const Target& target,
                                               const HttpRequest& request, OneShotSession& one_shot,
                                               RequestContext& context) {
  const auto wanted = co_await this->wanted(dataset, target, request, one_shot);
  if (!wanted) {
    const bool is_unacceptable = wanted.error().code == ErrorCode::kUnsupportedVersion;
    co_return is_unacceptable ? error_answer(406, wanted.error(), context.request_id)
                              : error_answer(wanted.error(), context.request_id);
  }
  Answer answer;
  add_field(answer, "Content-Type", media_type(wanted->form.format));
  add_field(answer, "Cache-Control", "no-cache");
  if (wanted->is_format_negotiated) add_field(answer, "Vary", "Accept");
  const std::optional<StoredMesh> known = meshes_.find(wanted->key);
  const bool needs_none = request.method() == http::verb::head ||
                          names_tag(field(request, http::field::if_none_match), wanted->tag);
  RequestFacts facts;
  facts.kind = "isosurface";
  facts.id = context.request_id;
  facts.dataset = dataset;
  facts.isovalue = wanted->requests.front().isovalue;
  facts.error = wanted->requests.front().error;
  facts.unit = multitetra::name(wanted->requests.front().unit);
  context.record = std::make_unique<RequestRecord>(context.client, std::move(facts));
  StoredMesh mesh;
  if (known) {
    mesh = *known;
  } else if (!needs_none) {
    auto made = co_await make(*wanted, one_shot, context);
    if (!made) {
      context.outcome = multitetra::name(made.error().code);
      co_return error_answer(made.error(), context.request_id);
    }
    mesh = *std::move(made);
  }
  if (mesh.file) {
    answer.fields += mesh.fields;
    answer.body = body_of(mesh.file, mesh.bytes);
  } else {
    answer.is_length_known = false;
  }
  if (!wanted->tag.empty()) meet_conditions(answer, request, wanted->tag);
  if (answer.status == 200 && mesh.file && mesh.bytes == 0) answer.status = 204;
  co_return answer;
}

}  // namespace multitetra
