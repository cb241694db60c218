// The file of serve --tokens, as `multitetra-server token` changes it: by one at a time, and
// readers find it whole at every moment.
//
//   TokenFile file("/etc/multitetra/tokens");
//   file.replace(file.text() + line + "\n");
#pragma once

#include <filesystem>
#include <string>

namespace multitetra {

// Waits until no other TokenFile of the same file is there. All functions throw std::system_error.
class TokenFile {
 public:
  enum class IfAbsent { kMakeIt, kFail };

  // A new file is empty and readable by its owner only; of root, in a folder of another group than
  // root's, by that group too: a service that reads its secrets from there is in it.
  explicit TokenFile(const std::filesystem::path& path, IfAbsent if_absent = IfAbsent::kFail);
  ~TokenFile();
  TokenFile(const TokenFile&) = delete;
  TokenFile& operator=(const TokenFile&) = delete;

  [[nodiscard]] std::string text() const;
  // With the mode and the owner that it has. Once.
  void replace(const std::string& text);

 private:
  [[noreturn]] void fail(const char* what) const;
  [[nodiscard]] bool is_current() const;

  std::filesystem::path path_;
  int descriptor_ = -1;  // Locked.
};

}  // namespace multitetra
