#include "common/base/atomic_file.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

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

  const fs::path folder_;
  const fs::path file_ = folder_ / "file.mtd";
};

using Names = std::vector<std::string>;

TEST_F(AtomicFileTest, APieceMayBeWrittenBeforeTheOneInFrontOfIt) {
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

TEST_F(AtomicFileTest, WithoutACommitTheOldFileStaysAndNothingElse) {
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

TEST_F(AtomicFileTest, OfTwoWritersTheLastCommitWins) {
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

TEST_F(AtomicFileTest, WhoHoldsTheOldFileOpenStillReadsIt) {
  std::ofstream(file_) << "old";
  std::ifstream old(file_);
  AtomicFile file(file_);
  write(file, 0, "new");
  file.commit(Durability::kProcessEnd);
  EXPECT_EQ((std::string{std::istreambuf_iterator<char>(old), {}}), "old");
  EXPECT_EQ(content(), "new");
}

TEST_F(AtomicFileTest, AKilledWriterLeavesTheOldFile) {
  std::ofstream(file_) << "old";
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    AtomicFile file(file_);
    write(file, 0, "half of the n");
    ::raise(SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(content(), "old");
}

TEST_F(AtomicFileTest, TheModeIsThatOfAnyNewFile) {
  AtomicFile file(file_);
  file.commit(Durability::kProcessEnd);
  std::ofstream(folder_ / "any") << "x";
  EXPECT_EQ(fs::status(file_).permissions(), fs::status(folder_ / "any").permissions());
}

TEST_F(AtomicFileTest, ALongNameHasRoomForItsTemporary) {
  const fs::path longest = folder_ / std::string(255, 'n');
  AtomicFile file(longest);
  file.commit(Durability::kMachineStop);
  EXPECT_TRUE(fs::exists(longest));
}

TEST_F(AtomicFileTest, TroubleNamesTheFileAndItsReason) {
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
