#include "server/routes/tilesets.hpp"

#include <algorithm>
#include <functional>
#include <memory>
#include <utility>

#include "server/http/conditions.hpp"
#include "server/http/media.hpp"
#include "server/service/run_on_workers.hpp"
#include "server/tilesets/cell_glb.hpp"
#include "server/tilesets/tileset_json.hpp"

namespace multitetra {
namespace {

// The version of the output. Increase it when equal paths give different bytes.
constexpr std::string_view kTilesetForm = "2 ";
constexpr std::string_view kSurfaceSuffix = ".glb";
constexpr std::string_view kTilesetSuffix = ".json";

tl::unexpected<Error> no_file(const TilesetFile& file) {
  return fail(ErrorCode::kUnknownDataset,
              "This tileset has no file \"" + file.file + "\"; tileset.json refers to all files.");
}

}  // namespace

Result<TilesetRoute::RequestedFilePtr> TilesetRoute::requested_file(const TilesetFile& file,
                                                                    const Permit& permit) {
  const std::string path = file.settings + '/' + file.id + '/' + file.file + '/' + file.dataset;
  auto info = permit.describe(file.dataset);
  if (!info) return tl::unexpected(info.error());
  const RequestedFilePtr* const known = paths_.find(path);
  if (known != nullptr && (*known)->tileset.info() == *info) return *known;
  auto wanted = resolved(file, *std::move(info));
  if (!wanted) return tl::unexpected(wanted.error());
  const auto kept = std::make_shared<const RequestedFile>(*std::move(wanted));
  paths_.add(path, kept, /*weight=*/1);
  return kept;
}

Result<TilesetRoute::RequestedFile> TilesetRoute::resolved(const TilesetFile& file,
                                                           DatasetInfo info) {
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

asio::awaitable<Result<SharedBytes>> TilesetRoute::make(const RequestedFile& wanted,
                                                        RequestContext& context) {
  if (context.watch) context.watch();
  const DatasetInfo& info = wanted.tileset.info();
  SurfaceRequest query{.dataset = info.name,
                       .request = wanted.tileset.request(wanted.cell),
                       .max_triangles = options_.max_mesh_triangles};
  auto made = co_await context.caller->surface(std::move(query));
  if (!made) co_return tl::unexpected(made.error());
  if (!wanted.is_surface) {
    const CellFacts facts{.is_empty = made->mesh.triangles.empty(),
                          .crossed_octants = made->crossed_octants};
    const std::string folder = wanted.is_first ? wanted.tileset.id() + "/" : "";
    co_return std::make_shared<const std::string>(
        tileset_json(wanted.tileset, wanted.cell, facts, folder));
  }
  const ByteReservations::Reservation memory = std::move(made->memory);
  std::function<Result<SharedBytes>()> write =
      [surface = std::make_shared<Surface>(*std::move(made)), info, cell = wanted.cell,
       codec = wanted.tileset.settings().codec] {
        return std::make_shared<const std::string>(
            cell_glb(std::move(surface->mesh), info, cell, codec));
      };
  co_return co_await run_on_workers<SharedBytes>(writing_, context.client->share(), "cell",
                                                 /*is_long=*/false, context.stop.get_token(),
                                                 std::move(write));
}

asio::awaitable<Answer> TilesetRoute::answer(const TilesetFile& file, const HttpRequest& request,
                                             RequestContext& context) {
  const Permit& permit = context.caller->permit();
  const auto found = requested_file(file, permit);
  if (!found) co_return context.refused(found.error());
  const RequestedFilePtr wanted = *found;
  const TilesetSettings& settings = wanted->tileset.settings();
  context.record->set_surface(settings.isovalue, settings.error,
                              multitetra::name(ErrorUnit::kVoxel));
  const bool is_lasting = wanted->is_known && !wanted->is_first;
  const std::string& tag = wanted->tag;
  Answer answer;
  add_field(answer, "Content-Type",
            wanted->is_surface ? media_type(MeshFormat::kGlb) : "application/json");
  const std::string scope = permit.is_for_all() ? "public" : "private";
  add_field(answer, "Cache-Control",
            scope + (is_lasting ? ", max-age=31536000, immutable" : ", no-cache"));
  const bool needs_none = request.method() == http::verb::head ||
                          matches_tag(field(request, http::field::if_none_match), tag);
  const SharedBytes* const known = kept_.find(wanted->key);
  if (known != nullptr) {
    answer.body = body_of(*known);
  } else if (needs_none) {
    answer.is_length_known = false;
  } else {
    auto made = co_await make(*wanted, context);
    if (!made) co_return context.refused(made.error());
    const SharedBytes bytes = *std::move(made);
    if (wanted->is_known) kept_.add(wanted->key, bytes, bytes->size() + wanted->key.size());
    answer.body = body_of(bytes);
  }
  if (!tag.empty()) apply_conditions(answer, request, tag);
  co_return answer;
}

}  // namespace multitetra
