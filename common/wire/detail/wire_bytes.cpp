#include "common/wire/detail/wire_bytes.hpp"

#include <algorithm>
#include <functional>
#include <span>

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/stubs/logging.h>
#include <google/protobuf/wire_format_lite.h>

namespace multitetra::wire {
namespace {

using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedInputStream;

// Calls `visit` after the tag of every field at the end of `path`; `visit` must consume the field.
// Returns false if the message that `input` is limited to is malformed.
using Visit = std::function<bool(CodedInputStream& input, std::uint32_t tag)>;
bool follow(CodedInputStream& input, std::span<const int> path, WireFormatLite::WireType type,
            const Visit& visit) {
  const bool is_end = path.size() == 1;
  const std::uint32_t wanted = WireFormatLite::MakeTag(
      path.front(), is_end ? type : WireFormatLite::WIRETYPE_LENGTH_DELIMITED);
  while (const std::uint32_t tag = input.ReadTag()) {
    if (tag != wanted) {
      if (!WireFormatLite::SkipField(&input, tag)) return false;
      continue;
    }
    if (is_end) {
      if (!visit(input, tag)) return false;
      continue;
    }
    std::uint32_t length = 0;
    if (!input.ReadVarint32(&length)) return false;
    const auto limit = input.PushLimit(static_cast<int>(std::min<std::uint64_t>(
        length, static_cast<std::uint64_t>(std::numeric_limits<int>::max()))));
    if (!follow(input, path.subspan(1), type, visit)) return false;
    input.PopLimit(limit);
  }
  return true;
}

void follow(std::string_view bytes, std::initializer_list<int> path, WireFormatLite::WireType type,
            const Visit& visit) {
  CodedInputStream input(reinterpret_cast<const std::uint8_t*>(bytes.data()),
                         static_cast<int>(bytes.size()));
  (void)follow(input, {path.begin(), path.size()}, type, visit);
}

}  // namespace

std::size_t count_entries(std::string_view bytes, std::initializer_list<int> path) {
  std::size_t entries = 0;
  follow(bytes, path, WireFormatLite::WIRETYPE_LENGTH_DELIMITED,
         [&entries](CodedInputStream& input, std::uint32_t tag) {
           ++entries;
           return WireFormatLite::SkipField(&input, tag);
         });
  return entries;
}

std::uint64_t last_number(std::string_view bytes, std::initializer_list<int> path) {
  std::uint64_t number = 0;
  follow(bytes, path, WireFormatLite::WIRETYPE_VARINT,
         [&number](CodedInputStream& input, std::uint32_t) { return input.ReadVarint64(&number); });
  return number;
}

void silence_protobuf_log() {
  [[maybe_unused]] static const auto silenced = google::protobuf::SetLogHandler(nullptr);
}

tl::unexpected<ParseError> refuse(ErrorCode code, std::string text, std::uint64_t request_id) {
  return tl::unexpected<ParseError>(ParseError{{code, std::move(text)}, request_id});
}

std::string not_a_message(std::string_view whose, std::size_t bytes) {
  return std::to_string(bytes) + " bytes are not a message of multitetra.v1; a " +
         std::string(whose) + " was expected.";
}

}  // namespace multitetra::wire
