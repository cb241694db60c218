#include "server/dataset/provenance.hpp"

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

TEST(DefaultDatasetName, OmitsFolderSuffixesAndPlaceholders) {
  EXPECT_EQ(default_dataset_name("a/chris_t1.nii.gz"), "chris_t1");
  EXPECT_EQ(default_dataset_name("a/cells.zarr/"), "cells");
  EXPECT_EQ(default_dataset_name("a/slice_%03d.tif"), "slice");
  EXPECT_EQ(default_dataset_name("a/scan-*_b.png"), "scan-_b");
  EXPECT_EQ(default_dataset_name("a/50%_full.nrrd"), "50%_full");
  EXPECT_EQ(default_dataset_name("a/*.tif"), "a");
  EXPECT_EQ(default_dataset_name("????.tif"), "images");
}

TEST(Provenance, ContainsTheHashOfTheFile) {
  const TemporaryFolder folder;
  // XXH3-128 of no bytes, from its specification.
  EXPECT_EQ(provenance(folder.file("empty.raw", "")),
            (Provenance{"empty.raw", "99aa06d3014798d86001c324468d497f"}));
  EXPECT_NE(provenance(folder.file("a.raw", "a")).digest,
            provenance(folder.file("b.raw", "b")).digest);
  EXPECT_EQ(provenance(folder.path() / "slices*.tif"), (Provenance{"slices*.tif", ""}));
}

}  // namespace
}  // namespace multitetra
