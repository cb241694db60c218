#include "server/dataset/provenance.hpp"

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

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
