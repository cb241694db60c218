#include "server/operations/access_list.hpp"

#include <algorithm>
#include <cstring>
#include <ctime>
#include <optional>
#include <sstream>
#include <stdexcept>

#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/rand.h>

#include "common/base/exit_codes.hpp"
#include "common/base/hex_text.hpp"
#include "server/operations/secret_file.hpp"

namespace multitetra {
namespace {

constexpr std::string_view kNoToken = "none";
constexpr std::string_view kExpires = "expires=";
constexpr std::string_view kSurfacesOnly = "only=surfaces";
constexpr std::string_view kColoredSurfacesOnly = "only=surfaces,colors";

std::optional<TokenDigest> digest_from(std::string_view hex) {
  TokenDigest digest;
  const auto bytes = bytes_from_hex(hex);
  if (!bytes || bytes->size() != digest.size()) return std::nullopt;
  std::memcpy(digest.data(), bytes->data(), digest.size());
  return digest;
}

// Returns the words before a comment. A '#' begins one only at the start of a word.
std::vector<std::string> words_of(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word && !word.starts_with('#');) words.push_back(word);
  return words;
}

tl::unexpected<Error> bad_line(std::size_t number, const std::string& what) {
  return fail(
      ErrorCode::kInvalidArgument,
      "Line " + std::to_string(number) + " " + what +
          "; a line is NAME, the token's SHA-256 as 64 hexadecimal digits (or none), and the "
          "datasets, for example * or head-*. Create one with: multitetra-server token NAME");
}

// Parses the words after the token: dataset patterns, and optionally the expiry time and
// only=surfaces or only=surfaces,colors.
Result<AccessRights> rights_from(const std::vector<std::string>& words, std::size_t line) {
  std::vector<std::string> datasets;
  std::optional<AccessRights::Time> expires;
  bool surfaces_only = false;
  bool colors = false;
  for (std::size_t i = 2; i < words.size(); ++i) {
    if (words[i] == kSurfacesOnly || words[i] == kColoredSurfacesOnly) {
      surfaces_only = true;
      colors = words[i] == kColoredSurfacesOnly;
      continue;
    }
    if (!words[i].starts_with(kExpires)) {
      datasets.push_back(words[i]);
      continue;
    }
    const auto time = time_from(std::string_view(words[i]).substr(kExpires.size()));
    if (!time || expires) {
      return bad_line(line,
                      "has \"" + words[i] +
                          "\", which is not a valid time, or is a second expires= (write expires=" +
                          "2027-01-31T12:00:00Z)");
    }
    expires = time;
  }
  if (datasets.empty()) return bad_line(line, "has no datasets");
  AccessRights rights(words[0], std::move(datasets));
  if (expires) rights.expire_at(*expires);
  if (surfaces_only) rights.allow_surfaces_only(colors);
  return rights;
}

}  // namespace

// Greedy matching with backtracking: after a mismatch the last * takes one more character.
bool matches(std::string_view pattern, std::string_view text) {
  std::size_t p = 0;
  std::size_t t = 0;
  std::size_t star = std::string_view::npos;
  std::size_t after_star = 0;
  while (t < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      after_star = t;
    } else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == text[t])) {
      ++p;
      ++t;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      t = ++after_star;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string_view::npos;
}

bool AccessRights::may_see(std::string_view dataset) const {
  return std::any_of(datasets_.begin(), datasets_.end(),
                     [&](const std::string& pattern) { return matches(pattern, dataset); });
}

TokenDigest digest_of_token(std::string_view token) {
  TokenDigest digest;
  unsigned int size = 0;
  if (EVP_Digest(token.data(), token.size(), digest.data(), &size, EVP_sha256(), nullptr) != 1) {
    throw std::runtime_error("OpenSSL cannot compute SHA-256.");
  }
  return digest;
}

const AccessList::Entry* AccessList::find(std::string_view token) const {
  const TokenDigest digest = digest_of_token(token);
  const Entry* found = nullptr;
  for (const Entry& entry : entries_) {  // No early exit: constant time.
    if (CRYPTO_memcmp(entry.digest.data(), digest.data(), digest.size()) == 0) found = &entry;
  }
  return found;
}

std::string AccessList::owner_of(std::string_view token) const {
  const Entry* const found = token.empty() ? nullptr : find(token);
  return found ? found->rights.name() : std::string();
}

Result<AccessRights> AccessList::rights_of(std::string_view token,
                                           std::chrono::system_clock::time_point now) const {
  if (token.empty()) {
    if (!anonymous_.empty() && !anonymous_.front().has_expired(now)) return anonymous_.front();
    return fail(ErrorCode::kUnauthenticated,
                "This server requires a token. Its operator issues them.");
  }
  const Entry* const found = find(token);
  if (found == nullptr) {
    return fail(ErrorCode::kUnauthenticated,
                "This server does not accept the token. Its operator issues tokens.");
  }
  if (found->rights.has_expired(now)) {
    return fail(ErrorCode::kUnauthenticated, "The token expired at " +
                                                 time_text(*found->rights.expires()) +
                                                 ". The server's operator issues tokens.");
  }
  return found->rights;
}

Result<AccessList> parse_access_list(std::string_view text) {
  AccessList list;
  std::istringstream lines{std::string(text)};
  bool has_strangers = false;
  std::size_t number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const std::vector<std::string> words = words_of(line);
    if (words.empty()) continue;
    if (words.size() < 3) return bad_line(number, "has fewer than three words");
    auto rights = rights_from(words, number);
    if (!rights) return tl::unexpected(rights.error());
    if (words[1] == kNoToken) {
      if (std::exchange(has_strangers, true)) {
        return bad_line(number, "is a second line for clients without a token");
      }
      list.add_anonymous(*std::move(rights));
      continue;
    }
    const auto digest = digest_from(words[1]);
    if (!digest) return bad_line(number, "does not have a SHA-256 as its second word");
    list.add({*digest, *std::move(rights)});
  }
  return list;
}

AccessListPtr load_access_list(const std::filesystem::path& file) {
  auto list = parse_access_list(read_secret_file("tokens file", file));
  if (!list) {
    throw ExitError(kBadCredentials, "The tokens file " + file.string() + ": " + list.error().text);
  }
  return std::make_shared<const AccessList>(*std::move(list));
}

std::string new_token() {
  std::array<unsigned char, 32> random;
  if (RAND_bytes(random.data(), static_cast<int>(random.size())) != 1) {
    throw std::runtime_error("The system cannot provide random numbers.");
  }
  return "mt_" + hex_text(std::as_bytes(std::span(random)));
}

std::string access_line(std::string_view name, std::string_view token,
                        const std::vector<std::string>& datasets,
                        std::optional<AccessRights::Time> expires, bool surfaces_only,
                        bool colors) {
  const TokenDigest digest = digest_of_token(token);
  std::string line = std::string(name) + " " + hex_text(std::as_bytes(std::span(digest)));
  for (const std::string& dataset : datasets) line += " " + dataset;
  if (expires) line += " " + std::string(kExpires) + time_text(*expires);
  if (surfaces_only) line += " " + std::string(colors ? kColoredSurfacesOnly : kSurfacesOnly);
  return line;
}

std::string time_text(AccessRights::Time time) {
  // system_clock's nanoseconds would overflow in 2262.
  const auto seconds = static_cast<std::time_t>(time.time_since_epoch().count());
  std::tm parts{};
  ::gmtime_r(&seconds, &parts);
  std::array<char, 32> text{};
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts)};
}

std::optional<AccessRights::Time> time_from(std::string_view text) {
  std::tm parts{};
  const std::string word(text);
  const char* const end = ::strptime(word.c_str(), "%Y-%m-%dT%H:%M:%SZ", &parts);
  if (end == nullptr || *end != '\0') return std::nullopt;
  const AccessRights::Time time{std::chrono::seconds(::timegm(&parts))};
  if (time_text(time) != text) return std::nullopt;  // Rejects dates like February 31.
  return time;
}

NameRemoval without_name(std::string_view text, std::string_view name) {
  NameRemoval without;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size() - 1) + 1;
    const std::vector<std::string> words = words_of(std::string(text.substr(0, end)));
    if (!words.empty() && words.front() == name) {
      ++without.removed;
    } else {
      without.text += text.substr(0, end);
    }
    text.remove_prefix(end);
  }
  return without;
}

}  // namespace multitetra
