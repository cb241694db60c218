#include "server/dataset/source_note.hpp"

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

TEST(SourceNote, HasTheHashOfTheFile) {
  const TemporaryFolder folder;
  // XXH3-128 of no bytes, as its specification gives it.
  EXPECT_EQ(source_note(folder.file("empty.raw", "")),
            (SourceNote{"empty.raw", "99aa06d3014798d86001c324468d497f"}));
  EXPECT_NE(source_note(folder.file("a.raw", "a")).digest,
            source_note(folder.file("b.raw", "b")).digest);
  EXPECT_EQ(source_note(folder.path() / "slices*.tif"), (SourceNote{"slices*.tif", ""}));
}

}  // namespace
}  // namespace multitetra
