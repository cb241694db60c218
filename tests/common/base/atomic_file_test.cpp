#include "common/base/atomic_file.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace multitetra {
namespace {

namespace fs = std::filesystem;

class AtomicFileTest : public ::testing::Test {
 protected:
  AtomicFileTest()
      : folder_(::testing::TempDir() + "multitetra_atomic_file_" + std::to_string(::getpid())) {
    fs::create_directories(folder_);
  }
  ~AtomicFileTest() override { fs::remove_all(folder_); }

  [[nodiscard]] std::vector<std::string> entries() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      names.push_back(entry.path().filename().string());
    }
    return names;
  }
  [[nodiscard]] std::string content() const {
    std::ifstream in(file_, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  }
  static void write(AtomicFile& file, std::uint64_t offset, std::string_view text) {
    file.write_at(offset, std::as_bytes(std::span(text)));
  }

  // Most file systems support unnamed temporary files; network file systems may not.
  [[nodiscard]] bool knows_nameless_files() const {
    const int descriptor = ::open(folder_.c_str(), O_TMPFILE | O_RDWR, 0600);
    if (descriptor >= 0) ::close(descriptor);
    return descriptor >= 0;
  }

  const fs::path folder_;
  const fs::path file_ = folder_ / "file.mtd";
};

using Names = std::vector<std::string>;

TEST_F(AtomicFileTest, WritesPiecesInAnyOrder) {
  for (const Durability durability : {Durability::kProcessEnd, Durability::kMachineStop}) {
    AtomicFile file(file_);
    write(file, 6, "world");
    write(file, 0, "hello");
    EXPECT_NE(content(), std::string("hello\0world", 11));
    file.commit(durability);
    EXPECT_EQ(content(), std::string("hello\0world", 11));
    EXPECT_EQ(entries(), Names{"file.mtd"});
    fs::remove(file_);
  }
}

TEST_F(AtomicFileTest, LeavesOnlyTheOldFileWithoutACommit) {
  std::ofstream(file_) << "old";
  try {
    AtomicFile file(file_);
    write(file, 0, "new and longer");
    throw std::runtime_error("something else went wrong");
  } catch (const std::runtime_error&) {
    EXPECT_EQ(content(), "old");
    EXPECT_EQ(entries(), Names{"file.mtd"});
  }
}

TEST_F(AtomicFileTest, KeepsTheLastOfTwoCommits) {
  AtomicFile first(file_);
  AtomicFile second(file_);
  write(second, 0, "second");
  write(first, 0, "first");
  second.commit(Durability::kProcessEnd);
  EXPECT_EQ(content(), "second");
  first.commit(Durability::kProcessEnd);
  EXPECT_EQ(content(), "first");
  EXPECT_EQ(entries(), Names{"file.mtd"});
}

TEST_F(AtomicFileTest, KeepsTheContentOfAnOpenOldFile) {
  std::ofstream(file_) << "old";
  std::ifstream old(file_);
  AtomicFile file(file_);
  write(file, 0, "new");
  file.commit(Durability::kProcessEnd);
  EXPECT_EQ((std::string{std::istreambuf_iterator<char>(old), {}}), "old");
  EXPECT_EQ(content(), "new");
}

// Writes half a file in a child process that is killed before it commits.
void write_half_and_die(const fs::path& path, AtomicFile::TemporaryKind before) {
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    AtomicFile file(path, before);
    const std::string_view half = "half of the n";
    file.write_at(0, std::as_bytes(std::span(half)));
    ::raise(SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status));
}

TEST_F(AtomicFileTest, LeavesOnlyTheOldFileWhenKilled) {
  std::ofstream(file_) << "old";
  write_half_and_die(file_, AtomicFile::TemporaryKind::kUnnamed);
  EXPECT_EQ(content(), "old");
  if (knows_nameless_files()) {
    EXPECT_EQ(entries(), Names{"file.mtd"});
  }
}

TEST_F(AtomicFileTest, RemovesOnlyLeftoversOfKilledWriters) {
  write_half_and_die(file_, AtomicFile::TemporaryKind::kHidden);
  ASSERT_EQ(entries().size(), 1U);
  const fs::path left = folder_ / entries().front();
  require_writable(file_);
  EXPECT_TRUE(fs::exists(left)) << "A writer may have begun just now.";

  AtomicFile at_work(file_, AtomicFile::TemporaryKind::kHidden);
  for (const char* other : {".other.mtd.0123456789abcdef.tmp", ".file.mtd.0123456789abcde.tmp",
                            ".file.mtd.0123456789ABCDEF.tmp"}) {
    std::ofstream(folder_ / other) << "x";
  }
  for (const std::string& name : entries()) {
    fs::last_write_time(folder_ / name, fs::file_time_type::clock::now() - std::chrono::hours(1));
  }
  ASSERT_EQ(entries().size(), 5U);
  require_writable(file_);
  EXPECT_FALSE(fs::exists(left));
  EXPECT_EQ(entries().size(), 4U);
  at_work.commit(Durability::kProcessEnd);
  EXPECT_TRUE(fs::exists(file_));
}

TEST_F(AtomicFileTest, CommitsHiddenTemporaryFiles) {
  std::ofstream(file_) << "old";
  AtomicFile file(file_, AtomicFile::TemporaryKind::kHidden);
  write(file, 0, "new");
  EXPECT_EQ(content(), "old");
  file.commit(Durability::kMachineStop);
  EXPECT_EQ(content(), "new");
  EXPECT_EQ(entries(), Names{"file.mtd"});
}

TEST_F(AtomicFileTest, ReportsUnwritablePathsInAdvance) {
  require_writable(file_);
  EXPECT_TRUE(entries().empty());
  std::ofstream(file_) << "old";
  require_writable(file_);
  EXPECT_EQ(content(), "old");
  EXPECT_THROW(require_writable(folder_ / "absent" / "a"), std::system_error);
}

TEST_F(AtomicFileTest, RejectsFoldersAndDevices) {
  const fs::path pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THROW(AtomicFile{pipe}, std::system_error);
  EXPECT_THROW(AtomicFile{folder_}, std::system_error);
  EXPECT_TRUE(fs::is_fifo(pipe));
}

TEST_F(AtomicFileTest, CreatesFilesWithTheDefaultMode) {
  AtomicFile file(file_);
  file.commit(Durability::kProcessEnd);
  std::ofstream(folder_ / "any") << "x";
  EXPECT_EQ(fs::status(file_).permissions(), fs::status(folder_ / "any").permissions());
}

TEST_F(AtomicFileTest, KeepsTheModeOfTheReplacedFile) {
  const auto mode = [this] { return fs::status(file_).permissions() & fs::perms::mask; };
  std::ofstream(file_) << "old";
  for (const AtomicFile::TemporaryKind before :
       {AtomicFile::TemporaryKind::kUnnamed, AtomicFile::TemporaryKind::kHidden}) {
    fs::permissions(file_, static_cast<fs::perms>(0640));
    AtomicFile(file_, before).commit(Durability::kProcessEnd);
    EXPECT_EQ(mode(), static_cast<fs::perms>(0640));
  }
}

TEST_F(AtomicFileTest, AcceptsTheLongestFileNames) {
  const fs::path longest = folder_ / std::string(255, 'n');
  AtomicFile file(longest);
  file.commit(Durability::kMachineStop);
  EXPECT_TRUE(fs::exists(longest));
}

TEST_F(AtomicFileTest, NamesTheFileAndTheReasonInErrors) {
  fs::create_directories(folder_ / "taken" / "inside");
  std::ofstream(folder_ / "no_folder") << "x";
  for (const fs::path& path :
       {folder_ / "absent" / "a", folder_ / "no_folder" / "a", folder_ / "taken"}) {
    try {
      AtomicFile(path).commit(Durability::kMachineStop);
      FAIL() << path;
    } catch (const std::system_error& error) {
      EXPECT_NE(std::string(error.what()).find(path.string()), std::string::npos) << error.what();
      EXPECT_NE(error.code().value(), 0);
    }
  }
  EXPECT_EQ(entries().size(), 2U);
}

}  // namespace
}  // namespace multitetra
