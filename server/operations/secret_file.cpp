#include "server/operations/secret_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "common/base/exit_codes.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{16} << 20;

class OpenFile {
 public:
  // O_NONBLOCK avoids waiting for a named pipe.
  explicit OpenFile(const std::filesystem::path& file)
      : descriptor_(::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY)) {}
  ~OpenFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  [[nodiscard]] int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

}  // namespace

std::string read_secret_file(const std::string& what, const std::filesystem::path& file) {
  const auto fail = [&](const std::string& why) -> ExitError {
    return {kBadCredentials, "The " + what + " " + file.string() + " " + why};
  };
  const auto reason = [] { return std::generic_category().message(errno); };
  const OpenFile opened(file);
  if (opened.descriptor() < 0) {
    throw fail(errno == ENOENT ? "does not exist."
                               : "cannot be read (" + reason() + "); may this user read it?");
  }
  struct stat status = {};
  if (::fstat(opened.descriptor(), &status) != 0) throw fail("cannot be read: " + reason() + ".");
  if (!S_ISREG(status.st_mode)) throw fail("cannot be read: it is no regular file.");
  std::string content;
  for (;;) {
    char piece[16 * 1024];  // NOLINT: it is read into before it is looked at.
    const ssize_t count = ::read(opened.descriptor(), piece, sizeof piece);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw fail("cannot be read: " + reason() + ".");
    if (count == 0) return content;
    content.append(piece, static_cast<std::size_t>(count));
    if (content.size() > kMaxBytes) throw fail("has more than 16 MiB; is it the right one?");
  }
}

}  // namespace multitetra
