// The messages between a program and its sandboxed process, either of which may lie: each is
// refused or has values in their ranges, and a conversation of any bytes ends.
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/sandbox/channel.hpp"
#include "common/sandbox/isolation.hpp"
#include "common/sandbox/packed.hpp"
#include "server/volume/detail/reader_messages.hpp"
#include "server/volume/formats/vtk/pvd_file.hpp"
#include "server/volume/labels/label_names.hpp"
#include "server/volume/volume_files.hpp"
#include "tests/fuzz/require.hpp"

namespace multitetra {
namespace {

void read_header(std::string_view bytes) {
  const auto header = header_from(bytes);
  if (!header) return;
  for (const std::int32_t side : header->dims) require(side >= 1 && side <= kMaxSide);
  require(bytes_per_sample(header->type) >= 1);
  require(header_text(*header) == bytes);
}

void read_contents(std::string_view bytes) {
  const auto contents = contents_from(bytes);
  if (!contents) return;
  const auto count = static_cast<std::size_t>(contents->times.count);
  require(contents->times.at.empty() || contents->times.at.size() == count);
  require(contents_from(contents_text(*contents)) == contents);
}

void read_answers(std::string_view bytes) {
  if (const auto labels = label_names_from(bytes)) {
    std::set<double> values;
    for (const Label& label : *labels) require(values.insert(label.value).second);
  }
  const auto entries = pvd_entries_from(bytes);
  if (entries) require(entries->size() <= kMaxSourceMembers);
}

void read_request(std::string_view bytes) {
  SandboxRules rules;
  if (unpack_all(bytes, rules)) require(packed_values(rules).size() <= bytes.size() + 8);
}

// Receives all that the other end has sent before it closed.
void converse(std::string_view bytes) {
  std::array<int, 2> ends{};
  require(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()) == 0);
  SandboxChannel channel(ends[0]);
  constexpr std::size_t kMostBuffered = 1 << 15;
  bytes = bytes.substr(0, kMostBuffered);
  require(::send(ends[1], bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size()));
  ::close(ends[1]);
  constexpr std::chrono::seconds kTime{5};
  constexpr std::uint64_t kMaxBytes = 1 << 14;
  SandboxMessage message;
  std::array<std::byte, 16> samples{};
  std::size_t received = 0;
  for (bool may_go_on = true; may_go_on; ++received) {
    may_go_on = received % 2 == 0
                    ? channel.receive(message, kTime, kMaxBytes)
                    : channel.receive_into('s', samples, message, kTime) || message.kind != 0;
    require(message.bytes.size() <= bytes.size() || !may_go_on);
  }
  require(received <= bytes.size() / 9 + 1);
}

}  // namespace
}  // namespace multitetra

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multitetra;
  if (size == 0) return 0;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0]) {
    case 'h':
      read_header(bytes);
      break;
    case 'c':
      read_contents(bytes);
      break;
    case 'a':
      read_answers(bytes);
      break;
    case 'r':
      read_request(bytes);
      break;
    default:
      converse(bytes);
  }
  return 0;
}
