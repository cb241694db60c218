#include "server/dataset/dataset_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <new>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "server/dataset/dataset_format.hpp"
#include "server/dataset/statistics.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail_on(const fs::path& file, const std::string& what) {
  throw DatasetFileError("'" + file.string() + "': " + what);
}

// With the system's reason for the last failed call.
[[noreturn]] void fail_with_reason(const fs::path& file, const std::string& what) {
  fail_on(file, what + ": " + std::generic_category().message(errno) + ".");
}

// An open file; closes itself.
class Descriptor {
 public:
  Descriptor(const fs::path& file, int flags)
      : value_(::open(file.c_str(), flags | O_CLOEXEC, 0644)) {
    if (value_ < 0) fail_with_reason(file, "it cannot be opened");
  }
  ~Descriptor() { ::close(value_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const { return value_; }

 private:
  int value_;
};

class FileSource : public ByteSource {
 public:
  explicit FileSource(const fs::path& file) : file_(file), descriptor_(file, O_RDONLY) {
    struct stat status = {};
    if (::fstat(descriptor_.get(), &status) != 0) fail_with_reason(file, "it cannot be examined");
    if (!S_ISREG(status.st_mode)) fail_on(file, "it is no regular file.");
    size_ = static_cast<std::uint64_t>(status.st_size);
  }

  [[nodiscard]] std::uint64_t size() const override { return size_; }

  void read(std::uint64_t offset, std::span<std::byte> into) const override {
    while (!into.empty()) {
      const ssize_t count =
          ::pread(descriptor_.get(), into.data(), into.size(), static_cast<off_t>(offset));
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) fail_with_reason(file_, "it cannot be read");
      if (count == 0) fail_on(file_, "it became shorter while it was read.");
      offset += static_cast<std::uint64_t>(count);
      into = into.subspan(static_cast<std::size_t>(count));
    }
  }

 private:
  fs::path file_;
  Descriptor descriptor_;
  std::uint64_t size_ = 0;
};

void write_all(const fs::path& file, const Descriptor& descriptor,
               std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(descriptor.get(), bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail_with_reason(file, "it cannot be written");
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
}

void synchronize(const fs::path& file, const Descriptor& descriptor) {
  if (::fsync(descriptor.get()) != 0) fail_with_reason(file, "it cannot be brought to the disk");
}

template <typename Decoded>
Decoded value_or_throw(const fs::path& file, Result<Decoded> decoded) {
  if (!decoded) fail_on(file, decoded.error().text);
  return *std::move(decoded);
}

}  // namespace

SourceNote source_note(const fs::path& source) {
  SourceNote note = {.file = source.filename().string(), .digest = {}};
  std::error_code error;
  if (!fs::is_regular_file(source, error)) return note;
  const FileSource file(source);
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(),
                                                                       &XXH3_freeState);
  XXH3_128bits_reset(state.get());
  std::vector<std::byte> portion(std::size_t{1} << 20);
  for (std::uint64_t done = 0; done < file.size();) {
    const auto count = std::min<std::uint64_t>(portion.size(), file.size() - done);
    file.read(done, std::span(portion).first(count));
    XXH3_128bits_update(state.get(), portion.data(), count);
    done += count;
  }
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(state.get()));
  constexpr std::string_view kDigits = "0123456789abcdef";
  for (const unsigned char byte : canonical.digest) {
    note.digest += kDigits[byte >> 4];
    note.digest += kDigits[byte & 15];
  }
  return note;
}

void write_dataset(const fs::path& path, const Dataset& dataset, const SourceNote& source) {
  assert(!first_problem(dataset.info));
  assert(dataset.info.dims == dataset.volume.dims && dataset.info.type == dataset.volume.type());
  const auto samples = sample_bytes(dataset.volume.samples);
  const std::string head = encode_head(
      {.info = dataset.info, .source = source, .program_version = MULTITETRA_VERSION}, samples);

  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  const fs::path temporary =
      folder / ("." + path.filename().string() + "." + std::to_string(::getpid()) + ".tmp");
  try {
    const Descriptor file(temporary, O_WRONLY | O_CREAT | O_TRUNC);
    write_all(temporary, file, std::as_bytes(std::span(head)));
    write_all(temporary, file, samples);
    synchronize(temporary, file);
    if (::rename(temporary.c_str(), path.c_str()) != 0) {
      fail_with_reason(path, "the finished file cannot be given this name");
    }
  } catch (...) {
    ::unlink(temporary.c_str());
    throw;
  }
  synchronize(folder, Descriptor(folder, O_RDONLY | O_DIRECTORY));  // The name itself.
}

DatasetPtr open_dataset(const fs::path& path) {
  try {
    auto decoded = value_or_throw(path, decode_dataset(FileSource(path)));
    return std::make_shared<const Dataset>(std::move(decoded.dataset));
  } catch (const std::bad_alloc&) {
    fail_on(path, "there is not enough memory for its samples.");
  }
}

SourceNote read_source_note(const fs::path& path) {
  return value_or_throw(path, decode_metadata(FileSource(path))).source;
}

}  // namespace multitetra
