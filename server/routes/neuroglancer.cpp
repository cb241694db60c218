#include "server/routes/neuroglancer.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <utility>

#include "common/request/request_key.hpp"
#include "server/http/conditions.hpp"
#include "server/service/run_on_workers.hpp"

namespace multitetra {
namespace {

// The version of the output, part of ETags. Increase it when equal paths give different bytes.
constexpr std::string_view kNeuroglancerForm = "3 ";
constexpr std::string_view kIndexSuffix = ".index";
constexpr std::string_view kInfo = "info";  // Suffix of files that list others.

SharedBytes shared(std::string bytes) {
  return std::make_shared<const std::string>(std::move(bytes));
}

tl::unexpected<Error> not_found_error(const NeuroglancerFile& file) {
  return fail(ErrorCode::kUnknownDataset, "This dataset has no file \"" + file.path +
                                              "\"; it has surfaces/info, surfaces/SEGMENT.index, "
                                              "image/info, and the files that they list.");
}

// Returns the tag of a mesh file or chunk, known before it is made. Returns none if the file is
// derived from the dataset's description only, or the dataset has no content digest; then the tag
// is computed from the bytes.
std::string lasting_tag(const NeuroglancerFile& file, const DatasetInfo& info) {
  if (info.content_id == 0 || file.path.ends_with(kInfo)) return {};
  const Tileset tileset(info, {.error = file.error});
  const std::string source = file.is_image ? "image" : text_of(tileset.settings());
  return tag_of(std::string(kNeuroglancerForm) + tileset.id() + ' ' + source + ' ' + file.path);
}

using Meshes = std::vector<LatticeMesh>;

std::size_t bytes_of(const ImageChunk& chunk, SampleType type) {
  std::size_t bytes = static_cast<std::size_t>(bytes_per_sample(type));
  for (const std::int32_t size : chunk.size) bytes *= static_cast<std::size_t>(size);
  return bytes;
}

// Appends values in the image's type. Void values are 0 if the type has no NaN.
void append_voxels(std::string& bytes, const std::string& values, SampleType type) {
  visit_type(type, [&]<typename Voxel>(const Voxel*) {
    for (std::size_t at = 0; at < values.size(); at += sizeof(float)) {
      float value = 0;
      std::memcpy(&value, values.data() + at, sizeof value);
      if constexpr (!std::is_floating_point_v<Voxel>) {
        if (std::isnan(value)) value = 0;
      }
      const auto voxel = static_cast<Voxel>(value);
      bytes.append(reinterpret_cast<const char*>(&voxel), sizeof voxel);
    }
  });
}

}  // namespace

// Tries all octants of the root; below it, only those that the surface crosses.
asio::awaitable<Result<void>> NeuroglancerRoute::make_fragment(const Tileset& tileset, MeshPtr mesh,
                                                               RequestContext& context) {
  const OctreeCube cell = mesh->left.front();
  const std::string& dataset = tileset.info().name;
  const auto pieces = std::make_shared<Meshes>();
  std::vector<ByteReservations::Reservation> memory;
  std::vector<OctreeCube> below;
  int resolution = kDefaultLatticeResolution;
  for (const IsosurfaceRequest& request : tileset.fragment_requests(cell)) {
    resolution = request.lattice_resolution;
    SurfaceRequest query{
        .dataset = dataset, .request = request, .max_triangles = options_.max_mesh_triangles};
    auto surface = co_await context.caller->surface(std::move(query));
    if (!surface) co_return tl::unexpected(surface.error());
    const OctreeCube& cube = request.cell->cube;
    if (cube != cell && surface->crossed_octants != 0) below.push_back(cube);
    if (surface->mesh.triangles.empty()) continue;
    memory.push_back(std::move(surface->memory));
    pieces->push_back(std::move(surface->mesh));
  }
  std::function<Result<SharedBytes>()> write = [pieces, cell, resolution] {
    return shared(mesh_fragment(weld(*pieces, resolution), cell));
  };
  auto made = co_await run_on_workers<SharedBytes>(writing_, context.client->share(), "fragment",
                                                   /*is_long=*/false, context.stop.get_token(),
                                                   std::move(write));
  if (!made) co_return tl::unexpected(made.error());
  // Another request for the same cell may have finished first.
  const auto at = std::find(mesh->left.begin(), mesh->left.end(), cell);
  if (at == mesh->left.end()) co_return Result<void>();
  mesh->left.erase(at);
  mesh->left.insert(mesh->left.end(), below.begin(), below.end());
  mesh->bytes += (*made)->size();
  mesh->fragments.emplace(cell, *std::move(made));
  if (mesh->left.empty()) {
    MeshFiles files = mesh_files_of(tileset, mesh->fragments);
    mesh->manifest = shared(std::move(files.manifest));
    mesh->data = shared(std::move(files.data));
    mesh->fragments.clear();
  }
  co_return Result<void>();
}

asio::awaitable<Result<NeuroglancerRoute::MeshPtr>> NeuroglancerRoute::mesh(
    const Tileset& tileset, RequestContext& context) {
  const std::string key = tileset.id() + ' ' + text_of(tileset.settings());
  const MeshPtr* const known = meshes_.find(key);
  MeshPtr mesh = known != nullptr ? *known : std::make_shared<Mesh>(Mesh{.left = {tileset.root()}});
  const auto until = std::chrono::steady_clock::now() + kMaxManifestWait;
  // Reserved for the files, as the cache may evict them meanwhile.
  ByteReservations::Reservation reservation;
  while (!mesh->left.empty()) {
    if (std::chrono::steady_clock::now() > until) {
      co_return tl::unexpected(Error{.code = ErrorCode::kUnavailable,
                                     .text = "The mesh is being generated; retry in 1 s.",
                                     .retry_after = 1});
    }
    const auto made = co_await make_fragment(tileset, mesh, context);
    if (!made) co_return tl::unexpected(made.error());
    if (mesh->bytes > kMaxBytes) {
      co_return fail(ErrorCode::kLimitExceeded,
                     "The mesh has more than " + std::to_string(kMaxBytes) +
                         " bytes; allow a larger error with surfaces,error=ERROR.");
    }
    reservation = {};
    auto more_reserved = context.client->reserve(mesh->bytes);
    if (!more_reserved) co_return tl::unexpected(more_reserved.error());
    reservation = *std::move(more_reserved);
    meshes_.add(key, mesh, mesh->bytes + 1024 * (1 + mesh->fragments.size()));
  }
  co_return mesh;
}

// Makes a chunk from its layers of samples.
asio::awaitable<Result<SharedBytes>> NeuroglancerRoute::image(const ImageChunk& chunk,
                                                              const DatasetInfo& info,
                                                              RequestContext& context) {
  std::string bytes;
  const auto reservation = context.client->reserve(bytes_of(chunk, info.type));
  if (!reservation) co_return tl::unexpected(reservation.error());
  for (std::int32_t z = 0; z < chunk.size[2]; ++z) {
    const SliceRequest plane{.coordinates = CoordinateSystem::kIndex,
                             .origin = chunk.to_index({0, 0, static_cast<double>(z)}),
                             .right = chunk.to_index.columns[0],
                             .down = chunk.to_index.columns[1],
                             .width = static_cast<std::uint32_t>(chunk.size[0]),
                             .height = static_cast<std::uint32_t>(chunk.size[1]),
                             .interpolation = Interpolation::kNearest,
                             .detail = SliceDetail::kFull};
    auto slice = co_await context.caller->slice(info.name, plane);
    if (!slice) co_return tl::unexpected(slice.error());
    append_voxels(bytes, *slice->values, info.type);
  }
  co_return shared(std::move(bytes));
}

asio::awaitable<Result<SharedBytes>> NeuroglancerRoute::content(const NeuroglancerFile& file,
                                                                const DatasetInfo& info,
                                                                RequestContext& context) {
  if (context.watch) context.watch();
  if (file.is_image) {
    if (file.path == "info") co_return shared(image_info_json(info));
    const std::size_t slash = file.path.find('/');
    if (slash == std::string::npos) co_return not_found_error(file);
    const auto chunk = image_chunk_from(info, std::string_view(file.path).substr(0, slash),
                                        std::string_view(file.path).substr(slash + 1));
    if (!chunk) co_return not_found_error(file);
    co_return co_await image(*chunk, info, context);
  }
  if (file.path == "info") co_return shared(mesh_info_json(info));
  if (file.path == "segment_properties/info") co_return shared(segment_properties_json(info));
  std::string_view segment = file.path;
  const bool is_index = segment.ends_with(kIndexSuffix);
  if (is_index) segment.remove_suffix(kIndexSuffix.size());
  const auto isovalue = isovalue_of_segment(segment);
  if (!isovalue) co_return not_found_error(file);
  const Tileset tileset(info, {.isovalue = *isovalue, .error = file.error});
  auto made = co_await mesh(tileset, context);
  if (!made) co_return tl::unexpected(made.error());
  const MeshPtr mesh = *std::move(made);
  if (mesh->data->empty()) {
    co_return fail(ErrorCode::kUnknownDataset, "There is no surface at this isovalue.");
  }
  co_return is_index ? mesh->manifest : mesh->data;
}

asio::awaitable<Answer> NeuroglancerRoute::answer(const NeuroglancerFile& file,
                                                  const HttpRequest& request,
                                                  RequestContext& context) {
  const auto info = context.caller->permit().describe(file.dataset);
  if (!info) co_return context.refused(info.error());
  const auto allowed = context.caller->permit().check_samples();
  if (file.is_image && !allowed) co_return context.refused(allowed.error());
  Answer answer;
  const bool is_info = file.path.ends_with(kInfo);
  add_field(answer, "Content-Type", is_info ? "application/json" : "application/octet-stream");
  add_field(answer, "Cache-Control",
            context.caller->permit().is_for_all() ? "public, no-cache" : "private, no-cache");
  std::string tag = lasting_tag(file, *info);
  const std::string_view had = field(request, http::field::if_none_match);
  // "*" comes from clients without a known version.
  if (!tag.empty() && had != "*" && matches_tag(had, tag)) {
    answer.is_length_known = false;
  } else {
    auto bytes = co_await content(file, *info, context);
    if (!bytes) co_return context.refused(bytes.error());
    const SharedBytes known = *std::move(bytes);
    if (tag.empty()) tag = tag_of(std::string(kNeuroglancerForm) + *known);
    answer.body = body_of(known);
  }
  apply_conditions(answer, request, tag);
  co_return answer;
}

}  // namespace multitetra
