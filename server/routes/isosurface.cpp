// Isosurfaces as files: one file per response.
#include <algorithm>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>

#include "common/base/number_text.hpp"
#include "common/request/request_key.hpp"
#include "common/request/shared_budget.hpp"
#include "server/http/conditions.hpp"
#include "server/http/media.hpp"
#include "server/operations/log.hpp"
#include "server/routes/detail/mesh_file.hpp"
#include "server/routes/detail/mesh_file_cache.hpp"
#include "server/routes/detail/mesh_query.hpp"
#include "server/routes/resource.hpp"

namespace multitetra {
namespace {

// The version of the output. Increase it when equal requests give different bytes.
constexpr std::string_view kFormVersion = "9";

// Returns nullopt if the temporary folder is not writable.
Result<std::optional<StoredMesh>> store_if_there_is_room(std::vector<Surface> surfaces,
                                                         const DatasetInfo& info,
                                                         const MeshFileOptions& form,
                                                         const MeshStorage& place,
                                                         const std::stop_token& stop) {
  try {
    auto stored = store_mesh(std::move(surfaces), info, form, place, stop);
    if (!stored) return tl::unexpected(stored.error());
    return *std::move(stored);
  } catch (const std::system_error& failure) {
    log_line(LogLevel::kError, std::string("writing a mesh file failed: ") + failure.what(),
             {{"dataset", info.name}, {"folder", place.folder.string()}});
    return std::nullopt;
  }
}

// Returns the bytes of a file for each of many triangles. They have half as many vertices; OBJ and
// compressed files are as measured on scans.
double bytes_of_triangle(const MeshFileOptions& form, bool has_normals, bool has_scalars) {
  const double normal = has_normals ? 12 : 0;
  switch (form.format) {
    case MeshFormat::kGlb:
      if (form.codec == MeshCodec::kMeshopt) return 4.5 + (has_scalars ? 3.5 : 0);
      return 12 + 0.5 * (24 + (has_scalars ? 16 : 0));
    case MeshFormat::kPly:
      return 13 + 0.5 * (12 + normal + (has_scalars ? 7 : 0));
    case MeshFormat::kStl:
      return 50;
    case MeshFormat::kVtp:
      return 32 + 0.5 * (12 + normal + (has_scalars ? 7 : 0));
    case MeshFormat::kObj:
      return 30 + 2 * normal;
    case MeshFormat::k3mf:
      return 12;
    case MeshFormat::kDrc:
      return 3.5 + normal / 6;
  }
  return 50;
}

// Returns the requested or an accepted format, which can hold this many surfaces.
Result<MeshFormat> format_for(const MeshQuery& query, const HttpRequest& request,
                              std::size_t surfaces) {
  const auto format =
      query.format ? query.format : accepted_format(field(request, http::field::accept));
  if (!format) {
    return fail(ErrorCode::kUnsupportedVersion,
                "Meshes are sent as model/gltf-binary, application/ply, model/stl, model/obj, "
                "application/vnd.draco, application/vnd.vtk.polydata+xml or model/3mf; the request "
                "accepts none of these.");
  }
  if (surfaces > 1 && !holds_several(*format)) {
    return fail(
        ErrorCode::kInvalidArgument,
        "Several surfaces in one file require format=glb or 3mf; otherwise request one at a time.");
  }
  if (const auto fits = check_codec(query.surface.codec, *format == MeshFormat::kGlb); !fits) {
    return tl::unexpected(fits.error());
  }
  return *format;
}

// Identifies the bytes of a file without scalars.
std::string key_of_file(const DatasetInfo& info, const std::vector<IsosurfaceRequest>& requests,
                        const MeshFileOptions& form) {
  std::string key = std::string(kFormVersion) + ' ' + std::string(media_type(form.format)) +
                    (form.is_in_world ? " w " : " i ") + std::string(name(form.codec)) + ' ' +
                    key_of(info);
  if (form.min_component > 0) key += " from " + shortest_text(form.min_component);
  for (const IsosurfaceRequest& one : requests) key += ' ' + key_of(one);
  return key;
}

// Identifies what scalars add to it.
std::string key_of_colors(const ColorScale& colors, const ScalarRange& range,
                          const DatasetInfo& field) {
  std::string key = " colors " + std::string(name(colors.map)) + ' ' + shortest_text(range.low) +
                    ' ' + shortest_text(range.high) + (colors.is_logarithmic ? " log" : "");
  for (const std::uint8_t part : colors.no_value) key += ' ' + std::to_string(part);
  return key + ' ' + key_of(field);
}

HttpResponse no_storage(RequestContext& context) {
  const Error error = {ErrorCode::kUnavailable,
                       "The temporary folder of this server is full or not writable; see its log. "
                       "Allow a larger error, or request the surface as a stream."};
  (void)context.refused(error);
  return error_answer(507, error, context.request_id);
}

// Everything that determines the file's bytes.
struct RequestedFile {
  DatasetInfo info;
  std::vector<IsosurfaceRequest> requests;  // One per surface.
  std::optional<ScalarRequest> scalars;
  MeshFileOptions form;
  bool is_format_negotiated = false;
  std::string key;  // Identifies the file's bytes.
  // Quoted; empty if the dataset has no content digest.
  std::string tag;
};

Result<RequestedFile> requested_file(const ResourceRequest& request) {
  const ClientAccess& client_access = request.context.service_client->client_access();
  const auto query = parse_mesh_query(request.target.query);
  if (!query) return tl::unexpected(query.error());
  auto info = client_access.describe(request.path[0]);
  if (!info) return tl::unexpected(info.error());
  auto surfaces = requests_for(query->surface, *info);
  if (!surfaces) return tl::unexpected(surfaces.error());
  auto scalars = scalars_for(query->surface);
  if (!scalars) return tl::unexpected(scalars.error());
  const auto format = format_for(*query, request.http, surfaces->size());
  if (!format) return tl::unexpected(format.error());
  RequestedFile wanted{
      .info = std::move(*info),
      .requests = *std::move(surfaces),
      .scalars = *std::move(scalars),
      .form = {.format = *format,
               .codec = query->surface.codec,
               .is_in_world = query->surface.coordinates == CoordinateSystem::kWorld,
               .colors = query->surface.colors,
               .color_by = query->surface.color_by,
               .min_component = query->surface.min_component},
      .is_format_negotiated = !query->format,
      .key = {},
      .tag = {}};
  wanted.key = key_of_file(wanted.info, wanted.requests, wanted.form);
  bool is_known = wanted.info.content_id != 0;
  std::optional<DatasetInfo> field;
  for (const IsosurfaceRequest& one : wanted.requests) {
    // The file may be cached for clients with other rights.
    const auto accepted = client_access.accept(OpenStream{.dataset = wanted.info.name,
                                                          .request = one,
                                                          .steps = StepPolicy::kFinalOnly,
                                                          .scalars = wanted.scalars});
    if (!accepted) return tl::unexpected(accepted.error());
    if (accepted->scalars) field = accepted->scalars->info();
  }
  if (field) {
    wanted.key += key_of_colors(wanted.form.colors, range_for(*wanted.scalars, *field), *field);
    is_known = is_known && field->content_id != 0;
  }
  if (is_known) wanted.tag = tag_of(wanted.key);
  return wanted;
}

class IsosurfaceRoute {
 public:
  explicit IsosurfaceRoute(const RouteOptions& options)
      : options_(options), meshes_(options.mesh_cache_bytes) {}

  // Makes nothing for HEAD, nor if the client's copy is current.
  [[nodiscard]] asio::awaitable<HttpResponse> answer(ResourceRequest request) {
    RequestContext& context = request.context;
    const auto wanted = requested_file(request);
    if (!wanted) {
      const bool is_unacceptable = wanted.error().code == ErrorCode::kUnsupportedVersion;
      co_return is_unacceptable
          ? error_answer(406, {ErrorCode::kInvalidArgument, wanted.error().text},
                         context.request_id)
          : context.refused(wanted.error());
    }
    HttpResponse response;
    add_field(response, "Content-Type", media_type(wanted->form.format));
    add_field(response, "Cache-Control", "no-cache");
    if (wanted->is_format_negotiated) add_field(response, "Vary", "Accept");
    const IsosurfaceRequest& first = wanted->requests.front();
    context.record->set_surface(first.isovalue, first.error, multitetra::name(first.unit));
    std::optional<StoredMesh> mesh = meshes_.find(wanted->key);
    if (!mesh && needs_body(request.http, wanted->tag)) {
      auto made = co_await make_within_budget(*wanted, context);
      if (!made) co_return context.refused(made.error());
      if (!*made) co_return no_storage(context);
      mesh = *std::move(made);
    }
    response.is_length_known = mesh.has_value();
    if (mesh) {
      response.fields += mesh->fields;
      response.body = mesh->body;
    }
    if (!wanted->tag.empty()) apply_conditions(response, request.http, wanted->tag);
    if (response.status == 200 && mesh && mesh->body.length == 0) response.status = 204;
    co_return response;
  }

 private:
  struct Made {
    // Absent if the temporary folder is not writable.
    std::optional<StoredMesh> file;
    // The number of triangles of the whole surfaces.
    std::uint64_t triangles = 0;
  };
  // Makes one file. The surfaces share a budget in proportion to their estimated sizes.
  [[nodiscard]] asio::awaitable<Result<Made>> make(const RequestedFile& wanted,
                                                   std::vector<IsosurfaceRequest> requests,
                                                   RequestContext& context) {
    if (needs_shared_budget(requests)) {
      std::vector<EstimatedSize> sizes;
      for (IsosurfaceRequest request : requests) {
        request.max_triangles = request.max_bytes = 0;
        const auto size =
            co_await context.service_client->estimate(wanted.info.name, std::move(request));
        if (!size) co_return tl::unexpected(size.error());
        sizes.push_back({.triangles = size->triangles, .bytes = size->bytes});
      }
      share_budget(requests, sizes);
    }
    SurfacesRequest surfaces{.dataset = wanted.info.name,
                             .requests = std::move(requests),
                             .scalars = wanted.scalars,
                             .max_triangles = options_.max_mesh_triangles};
    const MeshStorage place = {
        .max_in_memory = options_.max_mesh_bytes_in_memory,
        .folder = options_.temporary_folder,
        .reservation = [this, share = context.client->quota_key()](std::uint64_t bytes) {
          return meshes_.reserve(share, bytes);
        }};
    std::function<Result<Made>(std::vector<Surface>, const std::stop_token&)> store =
        [info = wanted.info, form = wanted.form, place](
            std::vector<Surface> made, const std::stop_token& stop) -> Result<Made> {
      std::uint64_t triangles = 0;
      for (const Surface& surface : made) triangles += surface.mesh.triangles.size();
      auto file = store_if_there_is_room(std::move(made), info, form, place, stop);
      if (!file) return tl::unexpected(file.error());
      return Made{.file = *std::move(file), .triangles = triangles};
    };
    co_return co_await context.service_client->made_from_surfaces<Made>(
        std::move(surfaces), "mesh file", std::move(store));
  }
  // Makes the wanted file. A budget of bytes is one of the file: a budget of triangles that is
  // corrected by the size of the file made with it.
  [[nodiscard]] asio::awaitable<Result<std::optional<StoredMesh>>> make_within_budget(
      const RequestedFile& wanted, RequestContext& context) {
    constexpr int kMaxFiles = 5;
    constexpr double kSafetyFactor = 0.98;  // Smaller meshes have more bytes per triangle.
    if (context.watch) context.watch();
    std::vector<IsosurfaceRequest> requests = wanted.requests;
    const std::uint64_t max_bytes = requests.front().max_bytes;
    const bool has_normals = requests.front().normal_bits > 0;
    double max_triangles = static_cast<double>(max_bytes) /
                           bytes_of_triangle(wanted.form, has_normals, wanted.scalars.has_value());
    for (int files = 1;; ++files) {
      for (std::size_t i = 0; max_bytes > 0 && i < requests.size(); ++i) {
        const std::uint64_t own = wanted.requests[i].max_triangles;
        const auto of_bytes =
            std::max<std::uint64_t>(static_cast<std::uint64_t>(max_triangles), requests.size());
        requests[i].max_bytes = 0;
        requests[i].max_triangles = own == 0 ? of_bytes : std::min(own, of_bytes);
      }
      auto made = co_await make(wanted, requests, context);
      if (!made) {
        Error error = made.error();
        if (max_bytes > 0 && error.code == ErrorCode::kLimitExceeded) {
          error.text = "A file of " + std::to_string(max_bytes) + " bytes has about " +
                       std::to_string(static_cast<std::uint64_t>(max_triangles)) + " triangles. " +
                       error.text;
        }
        co_return tl::unexpected(error);
      }
      const bool fits = max_bytes == 0 || !made->file || made->file->body.length <= max_bytes;
      if (fits) {
        if (made->file && !wanted.tag.empty()) meshes_.keep(wanted.key, *made->file);
        co_return std::move(made->file);
      }
      if (files == kMaxFiles || made->triangles == 0) {
        co_return fail(ErrorCode::kLimitExceeded,
                       "The file has at least " + std::to_string(made->file->body.length) +
                           " bytes, more than max_bytes. Allow more, or use another format.");
      }
      max_triangles = kSafetyFactor * static_cast<double>(made->triangles) *
                      static_cast<double>(max_bytes) / static_cast<double>(made->file->body.length);
    }
  }

  const RouteOptions& options_;
  MeshFileCache meshes_;
};

}  // namespace

Resource isosurface_resource(const ResourceContext& context) {
  const auto route = std::make_shared<IsosurfaceRoute>(context.options);
  return {.name = "isosurface",
          .path = "/v1/datasets/{name}/isosurface",
          .answer = [route](ResourceRequest request) { return route->answer(request); }};
}

}  // namespace multitetra
