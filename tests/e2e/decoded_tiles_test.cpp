// Tiles that pass through Draco weld to the extracted mesh, at every lattice resolution.

#include <gtest/gtest.h>

#include "server/extraction/surface_extractor.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/make_dataset.hpp"
#include "tests/support/tiled_surfaces.hpp"

namespace multitetra {
namespace {

namespace fields = testing::fields;

TEST(DecodedTiles, WeldToTheExtractedMeshAtEveryLatticeResolution) {
  // Noise gives tiles with many pieces and vertices where fans touch; a smooth field long seams.
  for (const DatasetPtr& dataset :
       {make_dataset(fields::noise({40, 33, 37}, 41), "noise"),
        make_dataset(fields::gyroid(65, 0.2, 42), "gyroid"),
        make_dataset(fields::integer_noise({33, 33, 33}, 4, 43), "plateaus", 0.0, 1)}) {
    const SurfaceExtractor extractor(dataset);
    const double isovalue = 0.4;
    for (const int resolution : {1, 3, 5, 8}) {
      SCOPED_TRACE(::testing::Message() << dataset->info.name << ", r = " << resolution);
      const StepRequest step{
          .request = {.isovalue = isovalue, .error = 0.25, .lattice_resolution = resolution}};
      const TiledMesh surface = extractor.extract(step);
      const std::vector<EncodedTile> encoded = testing::encode_tiles(surface);
      ASSERT_GE(encoded.size(), 3U);

      std::vector<LatticeMesh> decoded;
      for (std::size_t i = 0; i < encoded.size(); ++i) {
        auto mesh = decode_tile(*encoded[i].payload, encoded[i].summary, resolution);
        ASSERT_TRUE(mesh) << mesh.error().text;
        decoded.push_back(*std::move(mesh));
      }

      const LatticeMesh before = weld(surface.tiles, resolution);
      const LatticeMesh after = weld(decoded, resolution);
      const DataBorder border = data_border(dataset->info, resolution, 0);
      EXPECT_EQ(after.vertices.size(), before.vertices.size());
      EXPECT_EQ(digest(after), digest(before));
      EXPECT_EQ(topology(after, border), topology(before, border));
      EXPECT_TRUE(topology(after, border).is_sound());
    }
  }
}

}  // namespace
}  // namespace multitetra
