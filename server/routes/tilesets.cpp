// 3D Tiles tilesets, made on demand.
#include <algorithm>
#include <functional>
#include <memory>
#include <utility>

#include "common/base/lru_map.hpp"
#include "server/http/media.hpp"
#include "server/routes/resource.hpp"
#include "server/tilesets/cell_glb.hpp"
#include "server/tilesets/tileset.hpp"
#include "server/tilesets/tileset_json.hpp"

namespace multitetra {
namespace {

// The version of the output. Increase it when equal paths give different bytes.
constexpr std::string_view kTilesetForm = "2 ";
constexpr std::string_view kSurfaceSuffix = ".glb";
constexpr std::string_view kTilesetSuffix = ".json";

// {name}/iso/{settings}/tileset.json, and the files that it lists,
// {name}/iso/{settings}/{id}/{file}.
struct TilesetFile {
  std::string dataset;
  std::string settings;  // Parsed by tileset_settings_from().
  std::string id;        // Empty: the dataset's current id.
  std::string file;
};

Result<TilesetFile> tileset_file(const PathValues& path) {
  constexpr std::size_t kSegments = 4;
  const bool is_first = path.size() == kSegments && path.back() == "tileset.json";
  if ((!is_first && path.size() != kSegments + 1) || path[1] != "iso") {
    return fail(
        ErrorCode::kInvalidArgument,
        "3D Tiles are at /v1/3dtiles/DATASET/iso/ISOVALUE/tileset.json, or with the error of the "
        "finest level in voxels at /v1/3dtiles/DATASET/iso/ISOVALUE,error=ERROR/tileset.json; the "
        "tileset lists all further files.");
  }
  return TilesetFile{.dataset = path[0],
                     .settings = path[2],
                     .id = is_first ? std::string() : path[3],
                     .file = path.back()};
}

tl::unexpected<Error> no_file(const TilesetFile& file) {
  return fail(ErrorCode::kUnknownDataset,
              "This tileset has no file \"" + file.file + "\"; tileset.json refers to all files.");
}

// Everything that determines the file's bytes.
struct RequestedFile {
  Tileset tileset;
  OctreeCube cell;
  bool is_surface = false;  // Otherwise the cell's tileset.
  bool is_first = false;    // tileset.json, of the current dataset.
  // The dataset has a content digest.
  bool is_known = false;
  std::string key;
  // Quoted; empty if the dataset has no content digest.
  std::string tag;
};
using RequestedFilePtr = std::shared_ptr<const RequestedFile>;

Result<RequestedFile> resolved(const TilesetFile& file, DatasetInfo info) {
  const auto settings = tileset_settings_from(file.settings);
  if (!settings) return tl::unexpected(settings.error());
  const bool is_known = info.content_id != 0;
  RequestedFile wanted{.tileset = Tileset(std::move(info), *settings),
                       .cell = {},
                       .is_first = file.id.empty(),
                       .is_known = is_known,
                       .key = {},
                       .tag = {}};
  const std::string id = wanted.tileset.id();
  wanted.cell = wanted.tileset.root();
  if (!wanted.is_first) {
    if (file.id != id) {
      return fail(ErrorCode::kUnknownDataset,
                  "Dataset \"" + file.dataset + "\" has been replaced; reload its tileset.json.");
    }
    const std::string_view name = file.file;
    wanted.is_surface = name.ends_with(kSurfaceSuffix);
    const std::string_view suffix = wanted.is_surface ? kSurfaceSuffix : kTilesetSuffix;
    if (!name.ends_with(suffix)) return no_file(file);
    const auto cell = cell_from(name.substr(0, name.size() - suffix.size()));
    if (!cell || !wanted.tileset.contains(*cell)) return no_file(file);
    wanted.cell = *cell;
  }
  wanted.key = std::string(kTilesetForm) + id + ' ' + text_of(*settings) + ' ' +
               cell_name(wanted.cell) +
               (wanted.is_surface ? " glb"
                : wanted.is_first ? " first json"
                                  : " json");
  if (is_known) wanted.tag = tag_of(wanted.key);
  return wanted;
}

SharedBytes file_of(const RequestedFile& wanted, Surface surface) {
  const Tileset& tileset = wanted.tileset;
  if (wanted.is_surface) {
    return std::make_shared<const std::string>(
        cell_glb(std::move(surface.mesh), tileset.info(), wanted.cell, tileset.settings().codec));
  }
  const CellFacts facts{.is_empty = surface.mesh.triangles.empty(),
                        .crossed_octants = surface.crossed_octants};
  const std::string folder = wanted.is_first ? tileset.id() + "/" : "";
  return std::make_shared<const std::string>(tileset_json(tileset, wanted.cell, facts, folder));
}

// Used on the executor's thread only.
class TilesetRoute {
 public:
  // The options must outlive the route.
  explicit TilesetRoute(const RouteOptions& options) : options_(options) {}

  // A file costs at most the surface in one cell. Makes nothing for HEAD, nor if the client's copy
  // is current. Shared caches may store a response if the answer is for all clients.
  [[nodiscard]] asio::awaitable<HttpResponse> answer(ResourceRequest request) {
    RequestContext& context = request.context;
    const ClientAccess& client_access = context.service_client->client_access();
    const auto found = requested_file(request.path, client_access);
    if (!found) co_return context.refused(found.error());
    const RequestedFilePtr wanted = *found;
    const TilesetSettings& settings = wanted->tileset.settings();
    context.record->set_surface(settings.isovalue, settings.error,
                                multitetra::name(ErrorUnit::kVoxel));
    const bool is_lasting = wanted->is_known && !wanted->is_first;
    HttpResponse response;
    add_field(response, "Content-Type",
              wanted->is_surface ? media_type(MeshFormat::kGlb) : "application/json");
    const std::string scope = client_access.is_for_all() ? "public" : "private";
    add_field(response, "Cache-Control",
              scope + (is_lasting ? ", max-age=31536000, immutable" : ", no-cache"));
    const SharedBytes* const known = kept_.find(wanted->key);
    if (known != nullptr) {
      response.body = body_of(*known);
    } else if (!needs_body(request.http, wanted->tag)) {
      response.is_length_known = false;
    } else {
      const auto made = co_await make(wanted, context);
      if (!made) co_return context.refused(made.error());
      if (wanted->is_known) kept_.add(wanted->key, *made, (*made)->size() + wanted->key.size());
      response.body = body_of(*made);
    }
    if (!wanted->tag.empty()) apply_conditions(response, request.http, wanted->tag);
    co_return response;
  }

 private:
  [[nodiscard]] Result<RequestedFilePtr> requested_file(const PathValues& path,
                                                        const ClientAccess& client_access) {
    const auto file = tileset_file(path);
    if (!file) return tl::unexpected(file.error());
    const std::string key =
        file->settings + '/' + file->id + '/' + file->file + '/' + file->dataset;
    auto info = client_access.describe(file->dataset);
    if (!info) return tl::unexpected(info.error());
    const RequestedFilePtr* const known = paths_.find(key);
    if (known != nullptr && (*known)->tileset.info() == *info) return *known;
    auto wanted = resolved(*file, *std::move(info));
    if (!wanted) return tl::unexpected(wanted.error());
    const auto kept = std::make_shared<const RequestedFile>(*std::move(wanted));
    paths_.add(key, kept, /*weight=*/1);
    return kept;
  }
  [[nodiscard]] asio::awaitable<Result<SharedBytes>> make(RequestedFilePtr wanted,
                                                          RequestContext& context) {
    if (context.watch) context.watch();
    SurfacesRequest surface{.dataset = wanted->tileset.info().name,
                            .requests = {wanted->tileset.request(wanted->cell)},
                            .max_triangles = options_.max_mesh_triangles};
    std::function<Result<SharedBytes>(std::vector<Surface>, const std::stop_token&)> write =
        [wanted](std::vector<Surface> surfaces, const std::stop_token&) {
          return file_of(*wanted, std::move(surfaces.front()));
        };
    co_return co_await context.service_client->made_from_surfaces<SharedBytes>(
        std::move(surface), "cell", std::move(write));
  }

  static constexpr std::size_t kMaxCachedPaths = 1024;
  static constexpr std::size_t kMaxCachedBytes = std::size_t{64} << 20;

  const RouteOptions& options_;
  LruMap<std::string, SharedBytes> kept_{kMaxCachedBytes};
  // Parsed paths, valid while their dataset is unchanged.
  LruMap<std::string, RequestedFilePtr> paths_{kMaxCachedPaths};
};

}  // namespace

Resource tilesets_resource(const ResourceContext& context) {
  const auto route = std::make_shared<TilesetRoute>(context.options);
  return {.name = "3dtiles",
          .path = "/v1/3dtiles/{path...}",
          .kind = Resource::Kind::kMadeWithTokenInPath,
          .answer = [route](ResourceRequest request) { return route->answer(request); }};
}

}  // namespace multitetra
