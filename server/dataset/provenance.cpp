#include "server/dataset/provenance.hpp"

#include <xxhash.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "common/base/address_text.hpp"
#include "common/base/hex_text.hpp"
#include "server/dataset/byte_source.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kHashedPortionBytes = std::size_t{1} << 20;

class Digest {
 public:
  Digest() : state_(XXH3_createState(), &XXH3_freeState) { XXH3_128bits_reset(state_.get()); }

  void add(std::string_view text) { XXH3_128bits_update(state_.get(), text.data(), text.size()); }
  void add_file(const std::filesystem::path& path) {
    const FileSource file(path);
    std::vector<std::byte> portion(kHashedPortionBytes);
    for (std::uint64_t done = 0; done < file.size();) {
      const auto count = std::min<std::uint64_t>(portion.size(), file.size() - done);
      file.read(done, std::span(portion).first(count));
      XXH3_128bits_update(state_.get(), portion.data(), count);
      done += count;
    }
  }
  [[nodiscard]] std::string text() const {
    XXH128_canonical_t canonical;
    XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(state_.get()));
    return hex_text(std::as_bytes(std::span(canonical.digest)));
  }

 private:
  std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state_;
};

void add_folder(const std::filesystem::path& folder, Digest& digest) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  for (const std::filesystem::path& file : files) {
    digest.add(file.lexically_relative(folder).string() + '\0');
    digest.add(std::to_string(std::filesystem::file_size(file)) + '\0');
    digest.add_file(file);
  }
}

// Removes *, ? and %03d.
std::string without_placeholders(std::string_view pattern) {
  std::string rest;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    const std::size_t end = pattern.find_first_not_of("0123456789", i + 1);
    if (pattern[i] == '%' && end != std::string_view::npos && pattern[end] == 'd') {
      i = end;
    } else if (pattern[i] != '*' && pattern[i] != '?') {
      rest += pattern[i];
    }
  }
  return rest;
}

}  // namespace

std::string default_dataset_name(const std::filesystem::path& source) {
  std::filesystem::path name =
      source.filename().empty() ? source.parent_path().filename() : source.filename();
  if (name.extension() == ".gz" || name.extension() == ".bz2") name = name.stem();
  const std::string text = name.stem().string();
  const std::string rest = without_placeholders(text);
  if (rest == text) return text;
  const std::size_t first = rest.find_first_not_of("_-. ");
  if (first != std::string::npos) {
    return rest.substr(first, rest.find_last_not_of("_-. ") - first + 1);
  }
  const std::filesystem::path folder = source.parent_path();
  return folder.empty() ? "images" : folder.filename().string();
}

Provenance provenance(const std::filesystem::path& source) {
  const std::filesystem::path named = source.filename().empty() ? source.parent_path() : source;
  Provenance described = {
      .file = std::filesystem::path(without_password(named.string())).filename().string(),
      .digest = {}};
  std::error_code error;
  Digest digest;
  if (std::filesystem::is_directory(source, error)) {
    add_folder(source, digest);
  } else if (std::filesystem::is_regular_file(source, error)) {
    digest.add_file(source);
  } else {
    return described;
  }
  described.digest = digest.text();
  return described;
}

}  // namespace multitetra
