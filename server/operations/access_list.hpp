// The tokens file as a value: which token may see which datasets.
//
//   # name    SHA-256 of the token, in hex       datasets, with * and ?
//   alice     9f86d081884c7d659a2feaa0c55ad0...  head-* embryo
//   lab       5e884898da28047151d0e56f8dc629...  * expires=2027-01-31T12:00:00Z
//   guests    none                               public-* only=surfaces
//
//   const auto list = parse_access_list(text);
//   const auto rights = list->rights_of(hello.token);  // kUnauthenticated: an unknown token.
//   if (!rights->may_see("head-1")) ...                // Then it does not exist for this client.
//
// No token is stored, only its hash: tokens are random and long, so that the hash gives nothing
// away. A line with `none` is about clients without a token. The same name may have several lines,
// as while a token is replaced by another. A line that says when it expires (UTC) is as good as
// none from then on. With `only=surfaces` it gives meshes alone: no sample shells, slices or
// probes, which hold samples.
#pragma once

#include <array>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.hpp"

namespace multitetra {

// The datasets that a client may see. By default all of them.
class AccessRights {
 public:
  AccessRights() = default;
  AccessRights(std::string name, std::vector<std::string> datasets)
      : name_(std::move(name)), datasets_(std::move(datasets)) {}

  [[nodiscard]] bool may_see(std::string_view dataset) const;
  [[nodiscard]] const std::string& name() const { return name_; }  // For the log; may be empty.
  [[nodiscard]] const std::vector<std::string>& datasets() const { return datasets_; }

  // It gives meshes alone: nothing that holds samples.
  void allow_surfaces_only() { surfaces_only_ = true; }
  [[nodiscard]] bool surfaces_only() const { return surfaces_only_; }

  using Time = std::chrono::sys_seconds;
  void expire_at(Time time) { expires_ = time; }
  [[nodiscard]] const std::optional<Time>& expires() const { return expires_; }
  [[nodiscard]] bool has_expired(std::chrono::system_clock::time_point now) const {
    // In seconds: nanoseconds of the year 2400 do not fit into a number.
    return expires_ && std::chrono::floor<std::chrono::seconds>(now) >= *expires_;
  }

 private:
  std::string name_;
  std::vector<std::string> datasets_ = {"*"};  // Patterns, of which one must match.
  std::optional<Time> expires_;                // None: never.
  bool surfaces_only_ = false;
};

// Whether `text` is what `pattern` says: * stands for any characters, ? for one, all others for
// themselves. Costs O(pattern * text) at most.
[[nodiscard]] bool matches(std::string_view pattern, std::string_view text);

// SHA-256.
using TokenDigest = std::array<unsigned char, 32>;
[[nodiscard]] TokenDigest digest_of_token(std::string_view token);

class AccessList {
 public:
  struct Entry {
    TokenDigest digest = {};
    AccessRights rights = {};
  };

  // The rights of this token, empty for none. kUnauthenticated, with a text for the
  // client, unless the list knows it and it has not expired `now`. The time it takes reveals
  // nothing about the list's tokens.
  [[nodiscard]] Result<AccessRights> rights_of(
      std::string_view token,
      std::chrono::system_clock::time_point now = std::chrono::system_clock::now()) const;

  void add(Entry entry) { entries_.push_back(std::move(entry)); }
  void add_anonymous(AccessRights rights) { anonymous_.push_back(std::move(rights)); }
  [[nodiscard]] std::size_t size() const { return entries_.size(); }
  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }
  [[nodiscard]] const std::vector<AccessRights>& anonymous() const { return anonymous_; }

 private:
  std::vector<Entry> entries_;
  // The rights of clients without a token; at most one entry.
  std::vector<AccessRights> anonymous_;
};

// Null where everybody may see everything.
using AccessListPtr = std::shared_ptr<const AccessList>;

// kInvalidArgument, with the line's number and what would be right.
[[nodiscard]] Result<AccessList> parse_access_list(std::string_view text);
// Throws ExitError (kNoSecrets) that names the file when it cannot be read or parsed.
[[nodiscard]] AccessListPtr load_access_list(const std::filesystem::path& file);

// A new token of 256 random bits, and its line for the file.
[[nodiscard]] std::string new_token();
[[nodiscard]] std::string access_line(std::string_view name, std::string_view token,
                                      const std::vector<std::string>& datasets,
                                      std::optional<AccessRights::Time> expires = {},
                                      bool surfaces_only = false);

// A moment as the file has it, "2027-01-31T12:00:00Z"; none where it is no such moment.
[[nodiscard]] std::string time_text(AccessRights::Time time);
[[nodiscard]] std::optional<AccessRights::Time> time_from(std::string_view text);

// The file's text without the lines of that name, and how many there were. Comments stay.
struct NameRemoval {
  std::string text;
  std::size_t removed = 0;
};
[[nodiscard]] NameRemoval without_name(std::string_view text, std::string_view name);

}  // namespace multitetra
