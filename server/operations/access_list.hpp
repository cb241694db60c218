// Parses the tokens file: which token may see which datasets.
//
//   # name    SHA-256 of the token, in hex       datasets, with * and ?
//   alice     9f86d081884c7d659a2feaa0c55ad0...  head-* embryo
//   lab       5e884898da28047151d0e56f8dc629...  * expires=2027-01-31T12:00:00Z
//   guests    none                               public-* only=surfaces
//
//   const auto list = parse_access_list(text);
//   const auto rights = list->rights_of(hello.token);  // Or kUnauthenticated.
//   if (!rights->may_see("head-1")) ...                // Hidden from this client.
//
// Only hashes of tokens are stored. Tokens are long and random, so a hash reveals nothing. A `none`
// line applies to clients without a token. A name may have several lines, for example while a token
// is replaced. An expired line (UTC) is ignored. With `only=surfaces`, a client gets only meshes:
// no sample shells, slices or probes, which contain samples, and no colors by fields, which reveal
// them at the vertices, except with `only=surfaces,colors`.
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

// The datasets that a client may see. Default: all.
class AccessRights {
 public:
  AccessRights() = default;
  AccessRights(std::string name, std::vector<std::string> datasets)
      : name_(std::move(name)), datasets_(std::move(datasets)) {}

  [[nodiscard]] bool may_see(std::string_view dataset) const;
  [[nodiscard]] const std::string& name() const { return name_; }  // For the log; may be empty.
  [[nodiscard]] const std::vector<std::string>& datasets() const { return datasets_; }

  // Forbids everything that contains samples; with `colors`, surfaces may be colored by fields.
  void allow_surfaces_only(bool colors = false) {
    surfaces_only_ = true;
    colors_ = colors;
  }
  [[nodiscard]] bool surfaces_only() const { return surfaces_only_; }
  [[nodiscard]] bool colors() const { return colors_; }

  using Time = std::chrono::sys_seconds;
  void expire_at(Time time) { expires_ = time; }
  [[nodiscard]] const std::optional<Time>& expires() const { return expires_; }
  [[nodiscard]] bool has_expired(std::chrono::system_clock::time_point now) const {
    // In seconds: the nanoseconds of the year 2400 overflow.
    return expires_ && std::chrono::floor<std::chrono::seconds>(now) >= *expires_;
  }

 private:
  std::string name_;
  // At least one pattern must match.
  std::vector<std::string> datasets_ = {"*"};
  std::optional<Time> expires_;  // None: never.
  bool surfaces_only_ = false;
  bool colors_ = true;
};

// Returns whether `text` matches `pattern`: * matches any characters, ? any single one. Costs at
// most O(pattern * text).
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

  // Returns the rights of a token (empty: none). Returns kUnauthenticated, with a text for the
  // client, if the token is not in the list or has expired at `now`. The duration reveals nothing
  // about the list's tokens.
  [[nodiscard]] Result<AccessRights> rights_of(
      std::string_view token,
      std::chrono::system_clock::time_point now = std::chrono::system_clock::now()) const;

  // Returns the name of a token in the list, also of an expired one; otherwise "". Only for the
  // log.
  [[nodiscard]] std::string owner_of(std::string_view token) const;

  void add(Entry entry) { entries_.push_back(std::move(entry)); }
  void add_anonymous(AccessRights rights) { anonymous_.push_back(std::move(rights)); }
  [[nodiscard]] std::size_t size() const { return entries_.size(); }
  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }
  [[nodiscard]] const std::vector<AccessRights>& anonymous() const { return anonymous_; }

 private:
  // Returns null if the list does not contain the token. The duration reveals nothing about it.
  [[nodiscard]] const Entry* find(std::string_view token) const;

  std::vector<Entry> entries_;
  // Rights without a token; at most one entry.
  std::vector<AccessRights> anonymous_;
};

// Null: no access control.
using AccessListPtr = std::shared_ptr<const AccessList>;

// Parses a tokens file. Returns kInvalidArgument with the line number and the correct syntax.
[[nodiscard]] Result<AccessList> parse_access_list(std::string_view text);
// Throws ExitError (kBadCredentials), which names the file, if it cannot be read or parsed.
[[nodiscard]] AccessListPtr load_access_list(const std::filesystem::path& file);

// Returns a new token of 256 random bits, and its line for the file.
[[nodiscard]] std::string new_token();
[[nodiscard]] std::string access_line(std::string_view name, std::string_view token,
                                      const std::vector<std::string>& datasets,
                                      std::optional<AccessRights::Time> expires = {},
                                      bool surfaces_only = false, bool colors = false);

// Format and parse a UTC time of the file, such as "2027-01-31T12:00:00Z".
[[nodiscard]] std::string time_text(AccessRights::Time time);
[[nodiscard]] std::optional<AccessRights::Time> time_from(std::string_view text);

// Removes all lines with a name from a file's text, and counts them. Comments are kept.
struct NameRemoval {
  std::string text;
  std::size_t removed = 0;
};
[[nodiscard]] NameRemoval without_name(std::string_view text, std::string_view name);

}  // namespace multitetra
