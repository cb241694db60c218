#include "server/dataset/source_note.hpp"

#include <xxhash.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <system_error>
#include <vector>

#include "server/dataset/byte_source.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kHashedPortionBytes = std::size_t{1} << 20;

std::string hexadecimal(std::span<const unsigned char> bytes) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (const unsigned char byte : bytes) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

}  // namespace

SourceNote source_note(const std::filesystem::path& source) {
  SourceNote note = {.file = source.filename().string(), .digest = {}};
  std::error_code error;
  if (!std::filesystem::is_regular_file(source, error)) return note;
  const FileSource file(source);
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(),
                                                                       &XXH3_freeState);
  XXH3_128bits_reset(state.get());
  std::vector<std::byte> portion(kHashedPortionBytes);
  for (std::uint64_t done = 0; done < file.size();) {
    const auto count = std::min<std::uint64_t>(portion.size(), file.size() - done);
    file.read(done, std::span(portion).first(count));
    XXH3_128bits_update(state.get(), portion.data(), count);
    done += count;
  }
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(state.get()));
  note.digest = hexadecimal(canonical.digest);
  return note;
}

}  // namespace multitetra
