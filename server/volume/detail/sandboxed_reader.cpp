#include "server/volume/detail/sandboxed_reader.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <new>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>

#include "common/base/child_process.hpp"

namespace multitetra {
namespace {

// Kinds of messages. From the child: the header is known; further contents of the source; the
// opened volume's header; a notice; the reason of a failure; the requested samples. From the
// parent: the requested slices.
constexpr char kHeaderKnown = 'k';
constexpr char kContents = 'm';
constexpr char kOpened = 'o';
constexpr char kNotice = 'n';
constexpr char kFailed = 'f';
constexpr char kSamples = 's';
constexpr char kWanted = 'w';

constexpr std::uint64_t kHeaderMemory = std::uint64_t{1} << 30;
// For a layer of chunks, a chunk, the requested samples, and the address space of threads.
constexpr std::uint64_t kSamplesMemory = std::uint64_t{6} << 30;
constexpr std::chrono::minutes kHeaderTime{2};
constexpr std::chrono::hours kSamplesTime{1};

template <typename Plain>
std::string bytes_from(const Plain& plain) {
  static_assert(std::is_trivially_copyable_v<Plain>);
  return {reinterpret_cast<const char*>(&plain), sizeof(plain)};
}

// A VolumeHeader without its texts, which follow, each terminated by a zero.
struct PlainHeader {
  std::array<std::int32_t, 3> dims;
  SampleType type;
  Vec3 spacing;
  Affine index_to_world;
  WorldSpace space;
  GeometryBasis geometry;
};

std::string message_of(const VolumeSource& source) {
  const VolumeHeader& header = source.header();
  const PlainHeader plain = {.dims = header.dims,
                             .type = header.type,
                             .spacing = header.spacing,
                             .index_to_world = header.index_to_world,
                             .space = header.meaning.space,
                             .geometry = header.meaning.geometry};
  const auto& [space, length_unit, value_unit, geometry, assumed] = header.meaning;
  return bytes_from(plain) + length_unit + '\0' + value_unit + '\0' + assumed + '\0';
}

struct Wanted {
  std::int32_t first;
  std::int32_t count;
};

std::uint64_t machine_memory() {
  return static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) *
         static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

// ---- the child

void serve_source(const OpenSource& open, ChildChannel& parent) {
  const auto notice = [&](const std::string& text) { parent.send(kNotice, text); };
  const auto header_is_known = [&](std::uint64_t held_bytes) {
    set_memory_limit(std::min(kSamplesMemory + held_bytes, machine_memory()));
    parent.send(kHeaderKnown, {});
  };
  try {
    const std::unique_ptr<VolumeSource> source = open(notice, header_is_known);
    parent.send(kContents, contents_text(source->contents()));
    if (!parent.send(kOpened, message_of(*source))) return;
    ChildMessage message;
    Samples samples;
    while (parent.receive(message, std::chrono::hours(24 * 20)) && message.kind == kWanted) {
      Wanted wanted{};
      std::memcpy(&wanted, message.bytes.data(), sizeof(wanted));
      source->read(wanted.first, wanted.count, samples);
      const bool sent = std::visit(
          [&](const auto& values) {
            const auto bytes = std::as_bytes(std::span(values));
            return parent.send(kSamples,
                               {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
          },
          samples);
      if (!sent) return;
    }
  } catch (const std::bad_alloc&) {
    parent.send(kFailed, {});
  } catch (const std::exception& problem) {
    parent.send(kFailed, problem.what());
  }
}

// ---- the parent

class SandboxedVolume : public VolumeSource {
 public:
  SandboxedVolume(std::filesystem::path path, const OpenSource& open, Notice notice)
      : path_(std::move(path)),
        notice_(std::move(notice)),
        child_([&](ChildChannel& parent) { serve_source(open, parent); }, kHeaderMemory) {
    std::chrono::milliseconds timeout = kHeaderTime;
    ChildMessage message;
    while (true) {
      if (!child_.channel().receive(message, timeout)) give_up();
      if (message.kind == kOpened) break;
      if (message.kind == kHeaderKnown) timeout = kSamplesTime;
      handle(message);
    }
    PlainHeader plain{};
    std::memcpy(&plain, message.bytes.data(), sizeof(plain));
    std::string_view texts = std::string_view(message.bytes).substr(sizeof(plain));
    const auto next_text = [&] {
      const std::string_view text = texts.substr(0, texts.find('\0'));
      texts.remove_prefix(std::min(text.size() + 1, texts.size()));
      return std::string(text);
    };
    header_ = {.dims = plain.dims,
               .type = plain.type,
               .spacing = plain.spacing,
               .index_to_world = plain.index_to_world,
               .meaning = {.space = plain.space,
                           .length_unit = next_text(),
                           .value_unit = next_text(),
                           .geometry = plain.geometry,
                           .assumed = next_text()}};
  }

  [[nodiscard]] const VolumeHeader& header() const override { return header_; }
  [[nodiscard]] const VolumeContents& contents() const override { return contents_; }

  void read(std::int32_t first_slice, std::int32_t slices, Samples& into) override {
    resize(into, header_.type, static_cast<std::size_t>(slices) * header_.samples_per_slice());
    child_.channel().send(kWanted, bytes_from(Wanted{.first = first_slice, .count = slices}));
    const std::span<std::byte> bytes(
        bytes_of(into), static_cast<std::size_t>(slices) * header_.samples_per_slice() *
                            static_cast<std::size_t>(bytes_per_sample(header_.type)));
    ChildMessage other;
    // Notices precede the samples.
    while (!child_.channel().receive_into(kSamples, bytes, other, kSamplesTime)) {
      if (other.kind == 0) give_up();
      handle(other);
    }
  }

 private:
  // Handles a message other than a reply. Throws the child's failure.
  void handle(const ChildMessage& message) {
    if (message.kind == kContents) contents_ = contents_from(message.bytes);
    if (message.kind == kNotice && notice_) notice_(message.bytes);
    if (message.kind != kFailed) return;
    if (!message.bytes.empty()) throw VolumeFileError(message.bytes);
    fail_reading(path_, "there is not enough memory",
                 "Check that the file is complete, reduce the volume, or use a larger machine");
  }

  [[noreturn]] void give_up() {
    try {
      child_.throw_exit_reason();
    } catch (const ChildProcessError& problem) {
      fail_reading(path_, problem.what(), "It is damaged; get a complete copy of the file");
    }
  }

  std::filesystem::path path_;
  Notice notice_;
  ChildProcess child_;
  VolumeHeader header_;
  VolumeContents contents_;
};

}  // namespace

std::unique_ptr<VolumeSource> sandboxed_volume(const std::filesystem::path& path,
                                               const OpenSource& open, Notice notice) {
  return std::make_unique<SandboxedVolume>(path, open, std::move(notice));
}

}  // namespace multitetra
