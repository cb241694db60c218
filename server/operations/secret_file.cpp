#include "server/operations/secret_file.hpp"

#include <cerrno>
#include <system_error>

#include "common/base/exit_codes.hpp"
#include "common/base/open_file.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{16} << 20;

}  // namespace

std::string read_secret_file(const std::string& what, const std::filesystem::path& file) {
  const auto fail = [&](const std::string& why) -> ExitError {
    return {kBadCredentials, "The " + what + " " + file.string() + " " + why};
  };
  const auto reason = [] { return std::generic_category().message(errno); };
  const OpenFile opened(file);
  if (!opened.is_open()) {
    throw fail(errno == ENOENT
                   ? "does not exist."
                   : "cannot be read (" + reason() + "); check that this user may read it.");
  }
  if (!opened.regular_size()) throw fail("cannot be read: it is not a regular file.");
  auto content = opened.content(kMaxBytes + 1);
  if (!content) throw fail("cannot be read: " + reason() + ".");
  if (content->size() > kMaxBytes)
    throw fail("has more than 16 MiB; check that it is the right file.");
  return *std::move(content);
}

}  // namespace multitetra
