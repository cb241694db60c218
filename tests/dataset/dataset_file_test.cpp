#include "server/dataset/dataset_file.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "server/dataset/generators.hpp"
#include "tests/dataset/small_dataset.hpp"
#include "tests/dataset/temporary_folder.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

std::string error_of(const fs::path& file) {
  try {
    (void)open_dataset(file);
  } catch (const DatasetFileError& error) {
    EXPECT_NE(std::string(error.what()).find(file.filename().string()), std::string::npos)
        << "The error does not name the file: " << error.what();
    return error.what();
  }
  return "whole";
}

void expect_contains(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is not in: " << text;
}

TEST(DatasetFile, WhatIsWrittenIsOpenedAndNothingElseIsLeft) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "head.mtd";
  const DatasetPtr dataset =
      make_dataset(generate(GeneratorKind::kHead, {.size = 33, .noise = 10}), "head", -1000.0, 1);
  const SourceNote note = {.file = "generated head 33", .digest = ""};
  write_dataset(file, *dataset, note);
  const DatasetPtr opened = open_dataset(file);
  EXPECT_EQ(opened->info, dataset->info);
  EXPECT_EQ(opened->volume.samples, dataset->volume.samples);
  EXPECT_EQ(read_source_note(file), note);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1);
}

TEST(DatasetFile, ANewFileReplacesAnOldOneAndAFailedOneDoesNot) {
  const TemporaryFolder folder;
  const fs::path file = folder.file("small.mtd", "old");
  write_dataset(file, *small_dataset(), {});
  EXPECT_EQ(open_dataset(file)->info.name, "small");
  EXPECT_THROW(write_dataset(folder.path() / "none" / "a.mtd", *small_dataset(), {}),
               DatasetFileError);
  fs::create_directories(folder.path() / "taken.mtd" / "x");
  EXPECT_THROW(write_dataset(folder.path() / "taken.mtd", *small_dataset(), {}), DatasetFileError);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 2)
      << "A temporary file was left behind.";
}

TEST(DatasetFile, DamageIsReportedWithFileAndSection) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "small.mtd";
  write_dataset(file, *small_dataset(), {});
  const std::string whole = bytes_of_file(file);

  expect_contains(error_of(folder.path() / "none.mtd"), "cannot be opened");
  expect_contains(error_of(folder.path()), "no regular file");
  expect_contains(error_of(folder.file("empty.mtd", "")), "header");
  expect_contains(error_of(folder.file("other.mtd", std::string(1000, 'x'))), "header");
  expect_contains(error_of(folder.file("cut.mtd", whole.substr(0, whole.size() - 1))), "header");
  std::string changed = whole;
  changed.back() = static_cast<char>(changed.back() ^ 1);
  expect_contains(error_of(folder.file("changed.mtd", changed)), "\"samples\"");
  EXPECT_EQ(read_source_note(folder.path() / "changed.mtd"), SourceNote{});
  changed = whole;
  changed[changed.find("\"dims\"")] = '\'';
  expect_contains(error_of(folder.file("metadata.mtd", changed)), "\"metadata\"");
  EXPECT_THROW((void)read_source_note(folder.path() / "metadata.mtd"), DatasetFileError);
}

TEST(DatasetFile, TheSourceNoteHasTheHashOfTheFile) {
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
