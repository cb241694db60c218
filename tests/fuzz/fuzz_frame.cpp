// Frames do not depend on how the stream is split, and together they are the stream.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/net/frame.hpp"
#include "tests/fuzz/require.hpp"

namespace {

using multitetra::FrameReader;

struct Outcome {
  std::vector<std::string> frames;
  bool refused = false;

  friend bool operator==(const Outcome&, const Outcome&) = default;
};

// Feeds `portion` bytes at a time and takes out complete frames.
Outcome read(std::string_view stream, std::size_t portion) {
  FrameReader reader(1024);
  Outcome outcome;
  while (!outcome.refused && !stream.empty()) {
    reader.feed(stream.substr(0, portion));
    stream.remove_prefix(std::min(portion, stream.size()));
    while (true) {
      const auto frame = reader.next();
      if (!frame) outcome.refused = true;
      if (!frame || !*frame) break;
      outcome.frames.push_back(**frame);
    }
  }
  return outcome;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view stream(reinterpret_cast<const char*>(data) + 1, size - 1);
  const Outcome whole = read(stream, stream.size() + 1);
  require(read(stream, std::size_t{data[0]} + 1) == whole);
  std::string again;
  for (const std::string& frame : whole.frames) {
    require(!frame.empty() && frame.size() <= 1024);
    again += multitetra::frame_header(static_cast<std::uint32_t>(frame.size())) + frame;
  }
  require(stream.starts_with(again));
  return 0;
}
