// Neuroglancer's precomputed formats: surfaces as multi-resolution meshes, the volume as an image.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <utility>

#include "common/base/lru_map.hpp"
#include "common/base/parse_number.hpp"
#include "common/request/request_key.hpp"
#include "server/http/conditions.hpp"
#include "server/routes/resource.hpp"
#include "server/tilesets/neuroglancer.hpp"
#include "server/tilesets/neuroglancer_image.hpp"

namespace multitetra {
namespace {

// The version of the output, part of ETags. Increase it when equal paths give different bytes.
constexpr std::string_view kNeuroglancerForm = "3 ";
constexpr std::string_view kIndexSuffix = ".index";
constexpr std::string_view kInfo = "info";  // Suffix of files that list others.

// {name}/surfaces/{path}, or {name}/surfaces,error=0.5/{path}; {name}/image/{path}.
struct NeuroglancerFile {
  std::string dataset;
  bool is_image = false;
  // The error of the finest level, in voxels.
  double error = kDefaultError;
  std::string path;
};

Result<NeuroglancerFile> neuroglancer_file(const PathValues& path) {
  constexpr std::string_view kSurfaces = "surfaces";
  constexpr std::string_view kError = ",error=";
  NeuroglancerFile file{.dataset = path.empty() ? "" : path[0], .path = {}};
  std::string_view what = path.size() > 1 ? std::string_view(path[1]) : std::string_view();
  file.is_image = what == "image";
  bool is_known = file.is_image;
  if (what.starts_with(kSurfaces)) {
    what.remove_prefix(kSurfaces.size());
    is_known = what.empty();
    if (what.starts_with(kError)) {
      what.remove_prefix(kError.size());
      const auto error = parse_finite(what);
      is_known = error && *error >= 0;
      file.error = error.value_or(0);
    }
  }
  if (!is_known || path.size() < 3) {
    return fail(
        ErrorCode::kInvalidArgument,
        "Neuroglancer's sources are /v1/neuroglancer/DATASET/image and "
        "/v1/neuroglancer/DATASET/surfaces, or with the error of the finest level in voxels "
        "/v1/neuroglancer/DATASET/surfaces,error=ERROR, and the files that they list.");
  }
  for (std::size_t i = 2; i < path.size(); ++i) file.path.append(i > 2 ? "/" : "").append(path[i]);
  return file;
}

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

std::size_t bytes_of(const ImageChunk& chunk, SampleType type) {
  std::size_t bytes = static_cast<std::size_t>(bytes_per_sample(type));
  for (const std::int32_t size : chunk.size) bytes *= static_cast<std::size_t>(size);
  return bytes;
}

// Appends values in the image's type. If it has no NaN, void values are the least of the data,
// which is background of most.
void append_voxels(std::string& bytes, const std::string& values, const DatasetInfo& info) {
  visit_type(info.type, [&]<typename Voxel>(const Voxel*) {
    for (std::size_t at = 0; at < values.size(); at += sizeof(float)) {
      float value = 0;
      std::memcpy(&value, values.data() + at, sizeof value);
      if constexpr (!std::is_floating_point_v<Voxel>) {
        if (std::isnan(value)) value = static_cast<float>(info.min);
      }
      const auto voxel = static_cast<Voxel>(value);
      bytes.append(reinterpret_cast<const char*>(&voxel), sizeof voxel);
    }
  });
}

// A cell's fragment, and the octants below that the surface crosses.
struct MadeFragment {
  SharedBytes bytes;
  std::vector<OctreeCube> crossed;
};

MadeFragment fragment_of(const std::vector<Surface>& pieces, const OctreeCube& cell) {
  MadeFragment made;
  std::vector<const LatticeMesh*> meshes;
  for (const Surface& piece : pieces) {
    const OctreeCube& cube = piece.request.cell->cube;
    if (cube != cell && piece.crossed_octants != 0) made.crossed.push_back(cube);
    if (!piece.mesh.triangles.empty()) meshes.push_back(&piece.mesh);
  }
  made.bytes = shared(mesh_fragment(weld(meshes, pieces.back().request.lattice_resolution), cell));
  return made;
}

// Used on the executor's thread only.
class NeuroglancerRoute {
 public:
  // The options must outlive the route.
  explicit NeuroglancerRoute(const RouteOptions& options) : options_(options) {}

  // A mesh's manifest lists the sizes of all its fragments, so the first request for it, or for one
  // of its files, waits until all are made. After a few seconds it is answered with a retry delay;
  // finished fragments are kept. The service makes each cell as a separate request, with the usual
  // limits. Makes nothing if the client's copy is current.
  [[nodiscard]] asio::awaitable<HttpResponse> answer(ResourceRequest request) {
    RequestContext& context = request.context;
    const auto file = neuroglancer_file(request.path);
    if (!file) co_return context.refused(file.error());
    const ClientAccess& client_access = context.service_client->client_access();
    const auto info = client_access.describe(file->dataset);
    if (!info) co_return context.refused(info.error());
    const auto allowed = client_access.check_samples();
    if (file->is_image && !allowed) co_return context.refused(allowed.error());
    HttpResponse response;
    const bool is_info = file->path.ends_with(kInfo);
    add_field(response, "Content-Type", is_info ? "application/json" : "application/octet-stream");
    add_field(response, "Cache-Control",
              client_access.is_for_all() ? "public, no-cache" : "private, no-cache");
    std::string tag = lasting_tag(*file, *info);
    const std::string_view had = field(request.http, http::field::if_none_match);
    // "*" comes from clients without a known version.
    if (!tag.empty() && had != "*" && matches_tag(had, tag)) {
      response.is_length_known = false;
    } else {
      const auto bytes = co_await content(*file, *info, context);
      if (!bytes) co_return context.refused(bytes.error());
      if (tag.empty()) tag = tag_of(std::string(kNeuroglancerForm) + **bytes);
      response.body = body_of(*bytes);
    }
    apply_conditions(response, request.http, tag);
    co_return response;
  }

 private:
  // The fragments of one segment.
  struct Mesh {
    // Cells that the surface crosses and that are not made yet.
    std::vector<OctreeCube> left;
    MeshFragments fragments = {};
    std::size_t bytes = 0;
    // Set when `left` is empty: as MeshFiles, separate so that sending one retains only that.
    SharedBytes manifest = {};
    SharedBytes data = {};
  };
  using MeshPtr = std::shared_ptr<Mesh>;

  [[nodiscard]] asio::awaitable<Result<SharedBytes>> content(const NeuroglancerFile& file,
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
  // Makes a chunk from its layers of samples.
  [[nodiscard]] asio::awaitable<Result<SharedBytes>> image(const ImageChunk& chunk,
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
      auto slice = co_await context.service_client->slice(info.name, plane);
      if (!slice) co_return tl::unexpected(slice.error());
      append_voxels(bytes, *slice->values, info);
    }
    co_return shared(std::move(bytes));
  }
  [[nodiscard]] asio::awaitable<Result<MeshPtr>> mesh(const Tileset& tileset,
                                                      RequestContext& context) {
    const std::string key = tileset.id() + ' ' + text_of(tileset.settings());
    const MeshPtr* const known = meshes_.find(key);
    MeshPtr mesh =
        known != nullptr ? *known : std::make_shared<Mesh>(Mesh{.left = {tileset.root()}});
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
  // Makes the first of the remaining cells. Tries all octants of the root; below it, only those
  // that the surface crosses.
  [[nodiscard]] asio::awaitable<Result<void>> make_fragment(const Tileset& tileset, MeshPtr mesh,
                                                            RequestContext& context) {
    const OctreeCube cell = mesh->left.front();
    SurfacesRequest pieces{.dataset = tileset.info().name,
                           .requests = tileset.fragment_requests(cell),
                           .max_triangles = options_.max_mesh_triangles};
    std::function<Result<MadeFragment>(std::vector<Surface>, const std::stop_token&)> write =
        [cell](const std::vector<Surface>& surfaces, const std::stop_token&) {
          return fragment_of(surfaces, cell);
        };
    auto made = co_await context.service_client->made_from_surfaces<MadeFragment>(
        std::move(pieces), "fragment", std::move(write));
    if (!made) co_return tl::unexpected(made.error());
    // Another request for the same cell may have finished first.
    const auto at = std::find(mesh->left.begin(), mesh->left.end(), cell);
    if (at == mesh->left.end()) co_return Result<void>();
    mesh->left.erase(at);
    mesh->left.insert(mesh->left.end(), made->crossed.begin(), made->crossed.end());
    mesh->bytes += made->bytes->size();
    mesh->fragments.emplace(cell, std::move(made->bytes));
    if (mesh->left.empty()) {
      MeshFiles files = mesh_files_of(tileset, mesh->fragments);
      mesh->manifest = shared(std::move(files.manifest));
      mesh->data = shared(std::move(files.data));
      mesh->fragments.clear();
    }
    co_return Result<void>();
  }

  static constexpr std::size_t kMaxCachedBytes = std::size_t{256} << 20;
  // The size limit of one mesh, in bytes.
  static constexpr std::size_t kMaxBytes = kMaxCachedBytes / 2;
  static constexpr std::chrono::seconds kMaxManifestWait{8};

  const RouteOptions& options_;
  LruMap<std::string, MeshPtr> meshes_{kMaxCachedBytes};
};

}  // namespace

Resource neuroglancer_resource(const ResourceContext& context) {
  const auto route = std::make_shared<NeuroglancerRoute>(context.options);
  return {.name = "neuroglancer",
          .path = "/v1/neuroglancer/{path...}",
          .kind = Resource::Kind::kMadeWithTokenInPath,
          .answer = [route](ResourceRequest request) { return route->answer(request); }};
}

}  // namespace multitetra
