// Updates the file of serve --tokens for `multitetra-server token`: writers take turns, and readers
// always see a complete file.
//
//   TokenFile file("/etc/multitetra/tokens");
//   file.replace(file.text() + line + "\n");
#pragma once

#include <filesystem>
#include <string>

#include "common/base/open_file.hpp"

namespace multitetra {

// Waits until no other TokenFile has the file open. All functions throw std::system_error.
class TokenFile {
 public:
  enum class IfAbsent { kCreate, kFail };

  // A new file is empty and readable only by its owner. If root creates it in a folder of another
  // group, that group, the service's, may read it too.
  explicit TokenFile(const std::filesystem::path& path, IfAbsent if_absent = IfAbsent::kFail);

  [[nodiscard]] std::string text() const;
  // Atomically replaces the file, keeping mode and owner. May be called once.
  void replace(const std::string& text);

 private:
  [[noreturn]] void fail(const char* what) const;
  [[nodiscard]] bool is_current() const;

  std::filesystem::path path_;
  OpenFile opened_;
};

}  // namespace multitetra
