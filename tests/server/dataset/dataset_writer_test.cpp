#include "server/dataset/dataset_writer.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "server/dataset/prepared_file.hpp"
#include "tests/support/prepared_example.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/texts.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;
using testing::expect_contains;

std::string error_of_writing(const fs::path& path, const PreparedExample& example) {
  try {
    write_prepared(path, example);
  } catch (const DatasetFileError& error) {
    return error.what();
  }
  return "none";
}

// The steps of a writer, in order.
const std::vector<std::function<void(DatasetWriter&, const PreparedExample&)>> kSteps = {
    add_samples, add_spectrum, finish};

TEST(DatasetWriter, LeavesOnlyTheOldFileWithoutFinish) {
  const TemporaryFolder folder;
  const fs::path path = folder.file("a.mtd", "old");
  for (std::size_t steps = 0; steps < kSteps.size(); ++steps) {
    {
      DatasetWriter writer(path, small_prepared().metadata.info);
      for (std::size_t i = 0; i < steps; ++i) kSteps[i](writer, small_prepared());
    }
    EXPECT_EQ(bytes_of_file(path), "old");
    EXPECT_EQ(entries_of(folder.path()), 1U);
  }
}

// Returns the exit status of a child process that calls `act`.
int status_of_child(const std::function<void()>& act) {
  const pid_t child = ::fork();
  if (child == 0) {
    act();
    ::_exit(0);
  }
  int status = -1;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  return status;
}

TEST(DatasetWriter, LeavesTheOldOrTheNewFileWhenKilled) {
  const PreparedExample example = small_prepared();
  for (const bool has_old : {false, true}) {
    for (std::size_t steps = 0; steps <= kSteps.size(); ++steps) {
      const TemporaryFolder folder;
      const fs::path path = folder.path() / "a.mtd";
      if (has_old) folder.file("a.mtd", "old");
      const int status = status_of_child([&] {
        DatasetWriter writer(path, example.metadata.info);
        for (std::size_t i = 0; i < steps; ++i) kSteps[i](writer, example);
        ::raise(SIGKILL);
      });
      ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
      if (steps == kSteps.size()) {
        expect_holds(PreparedFile(path), example);
      } else if (has_old) {
        EXPECT_EQ(bytes_of_file(path), "old");
      } else {
        EXPECT_FALSE(fs::exists(path));
      }
      write_prepared(path, example);  // Leftovers of the killed writer do not interfere.
      expect_holds(PreparedFile(path), example);
    }
  }
}

// A file size limit simulates a full disk.
TEST(DatasetWriter, ReportsAFullDiskAndLeavesNoFile) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.mtd";
  const PreparedExample example = small_prepared();
  for (const rlim_t bytes : {0U, 100U, 4200U, 5000U}) {
    const int status = status_of_child([&] {
      ::signal(SIGXFSZ, SIG_IGN);
      const rlimit limit = {bytes, bytes};
      ::setrlimit(RLIMIT_FSIZE, &limit);
      const std::string text = error_of_writing(path, example);
      ::_exit(text.find("Cannot write ") == 0 ? 7 : 8);
    });
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 7) << bytes;
    EXPECT_EQ(entries_of(folder.path()), 0U) << bytes;
  }
}

TEST(DatasetWriter, KeepsTheFileOfTheLastWriter) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.mtd";
  const PreparedExample example = small_prepared();
  PreparedExample other = example;
  other.coarse[0] = 'X';
  DatasetWriter first(path, example.metadata.info);
  DatasetWriter second(path, other.metadata.info);
  add_samples(first, example);
  add_samples(second, other);
  add_spectrum(second, other);
  add_spectrum(first, example);
  finish(second, other);
  expect_holds(PreparedFile(path), other);
  finish(first, example);
  expect_holds(PreparedFile(path), example);
  EXPECT_EQ(entries_of(folder.path()), 1U);
}

TEST(DatasetWriter, NamesTheUnwritablePath) {
  const TemporaryFolder folder;
  folder.file("no_folder", "x");
  fs::create_directories(folder.path() / "taken.mtd" / "x");
  for (const char* name : {"none/a.mtd", "no_folder/a.mtd", "taken.mtd"}) {
    const std::string text = error_of_writing(folder.path() / name, small_prepared());
    expect_contains(text, (folder.path() / name).string());
  }
  EXPECT_EQ(entries_of(folder.path()), 2U) << "A temporary file was left behind.";

  if (::geteuid() == 0) return;  // Permissions do not restrict root.
  const fs::path closed = folder.path() / "closed";
  fs::create_directory(closed);
  fs::permissions(closed, fs::perms::owner_read | fs::perms::owner_exec);
  expect_contains(error_of_writing(closed / "a.mtd", small_prepared()), "Permission denied");
}

}  // namespace
}  // namespace multitetra
