#include "server/volume/detail/sandboxed_reader.hpp"

#include <unistd.h>

#include <algorithm>
#include <exception>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>

#include "common/base/utf8.hpp"
#include "common/sandbox/packed.hpp"
#include "server/volume/detail/reader_messages.hpp"

namespace multitetra {
namespace {

// Kinds of messages. From the reader: the header is known; further contents of the source; the
// opened volume's header; a notice; the rounding of all samples; the reason of a failure; the
// requested samples. From the parent: the memory for samples is granted; the requested slices.
constexpr char kHeaderKnown = 'k';
constexpr char kContents = 'm';
constexpr char kOpened = 'o';
constexpr char kNotice = 'n';
constexpr char kRounding = 'r';
constexpr char kFailed = 'f';
constexpr char kSamples = 's';
constexpr char kGranted = 'g';
constexpr char kWanted = 'w';

constexpr std::uint64_t kHeaderMemory = std::uint64_t{1} << 30;
// For a layer of chunks, a chunk, the requested samples, and the address space of threads.
constexpr std::uint64_t kSamplesMemory = std::uint64_t{6} << 30;
constexpr std::chrono::minutes kHeaderTime{2};
constexpr std::chrono::hours kSamplesTime{1};
constexpr std::chrono::hours kIdleTime{24 * 20};
constexpr int kMaxNotices = 10'000;
constexpr int kMaxGrants = 16;
constexpr std::size_t kMaxNoticeBytes = 4096;

struct Wanted {
  std::int32_t first;
  std::int32_t count;

  friend bool operator==(const Wanted&, const Wanted&) = default;
};

std::uint64_t machine_memory() {
  return static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) *
         static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

// ---- the reader

void serve_source(const OpenSource& open, const std::string& request, SandboxChannel& parent) {
  SandboxMessage message;
  const auto notice = [&](const std::string& text) { parent.send(kNotice, text); };
  const auto header_is_known = [&](std::uint64_t held_bytes) {
    parent.send(kHeaderKnown, packed_values(held_bytes));
    (void)parent.receive(message, kHeaderTime);
  };
  try {
    const std::unique_ptr<VolumeSource> source = open(request, notice, header_is_known);
    parent.send(kContents, contents_text(source->contents()));
    if (!parent.send(kOpened, header_text(source->header()))) return;
    Samples samples;
    std::string rounding;
    Wanted wanted{};
    while (parent.receive(message, kIdleTime) && message.kind == kWanted &&
           unpack_all(message.bytes, wanted)) {
      source->read(wanted.first, wanted.count, samples);
      if (const std::string now = source->rounding(); now != rounding) {
        rounding = now;
        parent.send(kRounding, rounding);
      }
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
  SandboxedVolume(std::filesystem::path path, const SandboxTask& task, const SandboxRules& rules,
                  const std::string& request, Notice notice)
      : path_(std::move(path)), notice_(std::move(notice)), reader_(task, rules, request) {
    std::chrono::minutes timeout = kHeaderTime;
    SandboxMessage message;
    while (true) {
      if (!reader_.channel().receive(message, timeout)) give_up(timeout);
      if (message.kind == kOpened) break;
      if (message.kind == kHeaderKnown) timeout = kSamplesTime;
      handle(message);
    }
    auto header = header_from(message.bytes);
    if (!header) refuse_answer();
    header_ = *std::move(header);
  }

  [[nodiscard]] const VolumeHeader& header() const override { return header_; }
  [[nodiscard]] const VolumeContents& contents() const override { return contents_; }
  [[nodiscard]] std::string rounding() const override { return rounding_; }

  // Of a volume that is read from the beginning, the reader makes the next slices meanwhile.
  void read(std::int32_t first_slice, std::int32_t slices, Samples& into) override {
    const Wanted wanted{.first = first_slice, .count = slices};
    const bool is_in_sequence = first_slice == 0 || first_slice == next_slice_;
    if (ahead_ && *ahead_ != wanted) {
      Samples unused;
      receive(*ahead_, unused);
    }
    if (!ahead_) request(wanted);
    receive(wanted, into);
    next_slice_ = first_slice + slices;
    if (is_in_sequence && next_slice_ < header_.dims[2]) {
      ahead_ = {.first = next_slice_, .count = std::min(slices, header_.dims[2] - next_slice_)};
      request(*ahead_);
    }
  }

 private:
  void request(const Wanted& wanted) { reader_.channel().send(kWanted, packed_values(wanted)); }

  // Receives the slices that were requested last.
  void receive(const Wanted& wanted, Samples& into) {
    const std::size_t samples =
        static_cast<std::size_t>(wanted.count) * header_.samples_per_slice();
    resize(into, header_.type, samples);
    const std::span<std::byte> bytes(
        bytes_of(into), samples * static_cast<std::size_t>(bytes_per_sample(header_.type)));
    SandboxMessage other;
    // Notices precede the samples.
    while (!reader_.channel().receive_into(kSamples, bytes, other, kSamplesTime)) {
      if (other.kind == 0) give_up(kSamplesTime);
      handle(other);
    }
    ahead_.reset();
  }

  // Handles a message other than a reply. Throws the reader's failure.
  void handle(const SandboxMessage& message) {
    // A few kinds, and notices: a process that sends more only wants to be waited for.
    if (++messages_ > kMaxNotices) refuse_answer();
    switch (message.kind) {
      case kHeaderKnown:
        if (++grants_ > kMaxGrants) refuse_answer();
        return grant_memory(message.bytes);
      case kContents:
        return take_contents(message.bytes);
      case kRounding:
        if (!is_unit_text(message.bytes)) refuse_answer();
        rounding_ = message.bytes;
        return;
      case kNotice:
        if (notice_) notice_(printable(message.bytes.substr(0, kMaxNoticeBytes)));
        return;
      case kFailed:
        if (!message.bytes.empty()) {
          throw VolumeFileError(printable(message.bytes.substr(0, kMaxNoticeBytes)));
        }
        fail_reading(path_,
                     "its reader needs more than the " + std::to_string((memory_limit_ >> 20) + 1) +
                         " MiB of memory that it may have",
                     "Reduce the volume, store it in smaller chunks, or use a larger machine");
      default:
        refuse_answer();
    }
  }

  void grant_memory(std::string_view bytes) {
    std::uint64_t held = 0;
    if (!unpack_all(bytes, held)) refuse_answer();
    const std::uint64_t most = machine_memory();
    memory_limit_ = std::min(kSamplesMemory + std::min(held, most), most);
    reader_.set_memory_limit(memory_limit_);
    reader_.channel().send(kGranted, {});
  }

  void take_contents(std::string_view text) {
    auto contents = contents_from(text);
    if (!contents) refuse_answer();
    contents_ = *std::move(contents);
  }

  [[noreturn]] void give_up(std::chrono::minutes limit) {
    try {
      reader_.throw_exit_reason();
    } catch (const SandboxTimeout&) {
      fail_reading(path_,
                   "its reader did not answer within " + std::to_string(limit.count()) +
                       " minutes, the limit",
                   "Copy it to faster storage, or store it without compression");
    } catch (const SandboxError& problem) {
      fail_reading(path_, problem.what(), "The file may be damaged; compare it with another copy");
    }
  }
  [[noreturn]] void refuse_answer() const {
    fail_reading(path_, "its reader does not answer as a reader does",
                 "Do not trust this file; get a copy from elsewhere");
  }

  std::filesystem::path path_;
  Notice notice_;
  Sandbox reader_;
  std::uint64_t memory_limit_ = kHeaderMemory;
  VolumeHeader header_;
  VolumeContents contents_;
  std::string rounding_;
  std::int32_t next_slice_ = 0;  // After those read last.
  std::optional<Wanted> ahead_;  // Requested and not received.
  int messages_ = 0;             // Besides replies.
  int grants_ = 0;
};

}  // namespace

SandboxTask reading(const std::string& name, OpenSource open) {
  return {name, [open = std::move(open)](SandboxChannel& parent, const std::string& request) {
            serve_source(open, request, parent);
          }};
}

std::unique_ptr<VolumeSource> sandboxed_volume(const std::filesystem::path& path,
                                               const SandboxTask& task, SandboxRules rules,
                                               const std::string& request, Notice notice) {
  rules.memory_bytes = kHeaderMemory;
  rules.most_memory_bytes = machine_memory();
  return std::make_unique<SandboxedVolume>(path, task, rules, request, std::move(notice));
}

}  // namespace multitetra
