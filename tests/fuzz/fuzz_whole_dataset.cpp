// A whole dataset with right checksums and any content is refused when it is opened or read, or
// gives surfaces, shells, slices, values and estimates, and its errors, whatever they are.
#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "server/core/planning/shell_steps.hpp"
#include "server/core/sampling/field_probe.hpp"
#include "server/dataset/prepare.hpp"
#include "server/dataset/prepared_file.hpp"
#include "server/dataset/verify_dataset.hpp"
#include "server/extraction/normal_encoder.hpp"
#include "server/extraction/sampled_slice.hpp"
#include "server/extraction/shell_extractor.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/extraction/surface_sizes.hpp"
#include "tests/fuzz/dataset_file_input.hpp"
#include "tests/fuzz/require.hpp"
#include "tests/support/memory_source.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

constexpr std::int64_t kMostSamples = 40 * 40 * 40;  // A few bytes may stand for more.

void extract(const SurfaceExtractor& extractor, const IsosurfaceRequest& request) {
  const DatasetInfo& info = extractor.dataset().info;
  const StepRequest step{.request = request};
  const TiledMesh surface = extractor.extract(step);
  const NormalEncoder normals(extractor.dataset(), step);
  for (const TileMesh& tile : surface.tiles) {
    const EncodedTile encoded = normals.encoded(tile, digest(tile.mesh));
    require(decode_tile(*encoded.payload, encoded.summary, request.lattice_resolution,
                        request.normal_bits)
                .has_value());
  }
  const StepRequest shells{.request = request, .shell = ShellStep()};
  if (has_shells(info, level_of(shells))) {
    (void)extract_shells(extractor.dataset(), level_of(shells));
  }
  const double triangles = surface_sizes(extractor).of(step).triangles;
  require(triangles >= 0);
}

void look_at(const DatasetPtr& dataset) {
  const DatasetInfo& info = dataset->info;
  const auto [width, height, depth] = info.dims;
  if (std::int64_t{width} * height * depth > kMostSamples) return;
  for (const Vec3& place : {Vec3{0, 0, 0}, Vec3{1.5, 2.5, 0.5}, Vec3{-1, 1e300, 0}}) {
    (void)probed(*dataset, CoordinateSystem::kIndex, place);
    (void)probed(*dataset, CoordinateSystem::kWorld, place);
  }
  const SliceRequest slice{.coordinates = CoordinateSystem::kIndex,
                           .origin = {0, 0, 1},
                           .right = {1, 0, 0},
                           .down = {0, 1, 0.1},
                           .width = 20,
                           .height = 20};
  (void)sampled_slice(*dataset, slice, {});
  const SurfaceExtractor extractor(dataset);
  std::vector<double> isovalues = info.suggested_isovalues;
  isovalues.resize(std::min<std::size_t>(isovalues.size(), 1));
  isovalues.push_back(info.min / 2 + info.max / 2);
  for (const double isovalue : isovalues) {
    extract(extractor, {.isovalue = isovalue, .error = 0.5, .simplify = true});
    extract(extractor, {.isovalue = isovalue, .error = 0, .normal_bits = 8});
  }
}

// Computes the missing errors of the file.
void complete_errors(const std::string& bytes, const DatasetInfo& info) {
  const auto [width, height, depth] = info.dims;
  if (std::int64_t{width} * height * depth > kMostSamples) return;
  const TemporaryFolder folder;
  const auto file = folder.file("dataset.mtd", bytes);
  (void)complete(file.string(), {}, folder.path() / "complete.mtd");
  verify_dataset(folder.path() / "complete.mtd");
}

}  // namespace
}  // namespace multitetra

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multitetra;
  const std::string file = dataset_file_of({reinterpret_cast<const char*>(data), size});
  const auto source = std::make_shared<const MemorySource>(std::as_bytes(std::span(file)));
  try {
    const PreparedFile opened("dataset", source);
    const DatasetPtr dataset = dataset_in(opened, "dataset");
    look_at(dataset);
    if (!opened.spectrum()) complete_errors(file, dataset->info);
  } catch (const DatasetFileError& damage) {
    require(std::string(damage.what()).size() > 10);
  } catch (const DamagedSpectrumError& damage) {
    require(std::string(damage.what()).size() > 10);
  }
  return 0;
}
