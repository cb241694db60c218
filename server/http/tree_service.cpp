#include "server/http/tree_service.hpp"

#include <algorithm>
#include <functional>
#include <memory>
#include <new>
#include <utility>

#include "server/http/conditions.hpp"
#include "server/http/media.hpp"
#include "server/http/on_workers.hpp"
#include "server/http/step_mesh.hpp"
#include "server/operations/log.hpp"
#include "server/trees/cell_glb.hpp"
#include "server/trees/tileset.hpp"

namespace multitetra {
namespace {

constexpr std::string_view kSurfaceSuffix = ".glb";
constexpr std::string_view kTilesetSuffix = ".json";

Result<SharedBytes> surface_file(const OneShotSession::Step& step, const DatasetInfo& info,
                                 const OctreeCube& cell, const std::stop_token& stop) {
  auto mesh = welded_mesh(step, stop);
  if (!mesh) return tl::unexpected(mesh.error());
  if (digest(*mesh) != step.end.digest) {
    return fail(ErrorCode::kDamagedData,
                "The cell's surface is not the one that was announced: this is the server's "
                "mistake.");
  }
  return std::make_shared<const std::string>(cell_glb(*std::move(mesh), info, cell));
}

Result<SharedBytes> guarded_surface_file(const OneShotSession::Step& step, const DatasetInfo& info,
                                         const OctreeCube& cell, const std::stop_token& stop) {
  try {
    return surface_file(step, info, cell, stop);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kLimitExceeded,
                "The server has not enough memory for this cell's file; allow a larger error.");
  } catch (const std::exception& trouble) {
    log_line(LogLevel::kError, std::string("making a cell's file failed: ") + trouble.what(),
             {{"dataset", info.name}});
    return fail(ErrorCode::kInternal, "The server failed to make this file; its log says why.");
  }
}

tl::unexpected<Error> no_file(const TreeFile& file) {
  return fail(ErrorCode::kUnknownDataset, "This tree has no file \"" + file.file +
                                              "\"; tileset.json leads to those that there are.");
}

}  // namespace

asio::awaitable<Result<TreeService::Wanted>> TreeService::wanted(const TreeFile& file,
                                                                 OneShotSession& one_shot) {
  const auto settings = tree_settings_from(file.settings);
  if (!settings) co_return tl::unexpected(settings.error());
  auto info = co_await one_shot.dataset(file.dataset);
  if (!info) co_return tl::unexpected(info.error());
  const bool is_known = info->content_id != 0;
  Wanted wanted{.tree = CellTree(std::move(*info), *settings),
                .cell = {},
                .is_first = file.id.empty(),
                .is_known = is_known,
                .key = {}};
  const std::string id = wanted.tree.id();
  wanted.cell = wanted.tree.root();
  if (!wanted.is_first) {
    if (file.id != id) {
      co_return fail(
          ErrorCode::kUnknownDataset,
          "Dataset \"" + file.dataset + "\" is another one now; load its tileset.json again.");
    }
    const std::string_view name = file.file;
    wanted.is_surface = name.ends_with(kSurfaceSuffix);
    const std::string_view suffix = wanted.is_surface ? kSurfaceSuffix : kTilesetSuffix;
    if (!name.ends_with(suffix)) co_return no_file(file);
    const auto cell = cell_from(name.substr(0, name.size() - suffix.size()));
    if (!cell || !wanted.tree.contains(*cell)) co_return no_file(file);
    wanted.cell = *cell;
  }
  wanted.key = id + ' ' + text_of(*settings) + ' ' + cell_name(wanted.cell) +
               (wanted.is_surface ? " glb"
                : wanted.is_first ? " first json"
                                  : " json");
  co_return wanted;
}

asio::awaitable<Result<SharedBytes>> TreeService::make(const Wanted& wanted,
                                                       OneShotSession& one_shot,
                                                       RequestContext& context) {
  context.stop = std::stop_source();
  if (context.watch) context.watch();
  const DatasetInfo& info = wanted.tree.info();
  auto made = co_await one_shot.final_step(info.name, wanted.tree.request(wanted.cell),
                                           options_.max_mesh_triangles);
  if (!made) co_return tl::unexpected(made.error());
  const auto step = std::make_shared<const OneShotSession::Step>(*std::move(made));
  if (!wanted.is_surface) {
    const CellFacts facts{.is_empty = step->begin.tiles.empty(),
                          .crossed_octants = step->begin.crossed_octants};
    const std::string folder = wanted.is_first ? wanted.tree.id() + "/" : "";
    co_return std::make_shared<const std::string>(
        tileset_json(wanted.tree, wanted.cell, facts, folder));
  }
  const auto waiting = context.client->take_room(step->end.payload_bytes);
  if (!waiting) co_return tl::unexpected(waiting.error());
  std::function<Result<SharedBytes>()> write = [step, info, cell = wanted.cell,
                                                stop = context.stop.get_token()] {
    return guarded_surface_file(*step, info, cell, stop);
  };
  co_return co_await on_workers<SharedBytes>(writing_, context.client->share(), "cell",
                                             /*is_long=*/false, std::move(write));
}

asio::awaitable<Answer> TreeService::answer(const TreeFile& file, const HttpRequest& request,
                                            OneShotSession& one_shot, RequestContext& context,
                                            bool is_for_all) {
  const auto wanted = co_await this->wanted(file, one_shot);
  if (!wanted) co_return error_answer(wanted.error(), context.request_id);
  const bool is_lasting = wanted->is_known && !wanted->is_first;
  const std::string tag = wanted->is_known ? tag_of(wanted->key) : std::string();
  Answer answer;
  add_field(answer, "Content-Type",
            wanted->is_surface ? media_type(MeshFormat::kGlb) : "application/json");
  const std::string who = is_for_all ? "public" : "private";
  add_field(answer, "Cache-Control",
            who + (is_lasting ? ", max-age=31536000, immutable" : ", no-cache"));
  const bool needs_none = request.method() == http::verb::head ||
                          names_tag(field(request, http::field::if_none_match), tag);
  const SharedBytes* const known = kept_.find(wanted->key);
  if (known != nullptr) {
    answer.body = body_of(*known);
  } else if (needs_none) {
    answer.is_length_known = false;
  } else {
    RequestFacts facts;
    facts.kind = "3dtiles";
    facts.id = context.request_id;
    facts.dataset = file.dataset;
    facts.isovalue = wanted->tree.settings().isovalue;
    facts.error = wanted->tree.settings().error;
    facts.unit = multitetra::name(LengthUnit::kVoxel);
    context.record = std::make_unique<RequestRecord>(context.client, std::move(facts));
    auto made = co_await make(*wanted, one_shot, context);
    if (!made) {
      context.outcome = multitetra::name(made.error().code);
      co_return error_answer(made.error(), context.request_id);
    }
    const SharedBytes bytes = *std::move(made);
    if (wanted->is_known) kept_.add(wanted->key, bytes, bytes->size() + wanted->key.size());
    answer.body = body_of(bytes);
  }
  if (!tag.empty()) meet_conditions(answer, request, tag);
  co_return answer;
}

}  // namespace multitetra
