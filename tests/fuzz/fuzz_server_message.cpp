// A parsed message is in range, so it can be written and parsed again with the same result.
#include <cstddef>
#include <cstdint>
#include <string>

#include "common/wire/messages.hpp"
#include "tests/fuzz/require.hpp"
#include "tests/support/sample_messages.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto parsed = multitetra::parse_server_message({reinterpret_cast<const char*>(data), size});
  if (!parsed) {
    require(!parsed.error().error.text.empty());
    return 0;
  }
  const std::string bytes = multitetra::serialize(*parsed);
  const auto again = multitetra::parse_server_message(bytes);
  require(again.has_value());
  require(multitetra::samples::same(*parsed, *again));
  return 0;
}
