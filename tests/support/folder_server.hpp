// Serves a folder over HTTP by serve_folder.py, which can simulate faults.
#pragma once

#include <signal.h>

#include <cstdio>
#include <filesystem>
#include <sstream>
#include <string>

namespace multitetra {

// Runs serve_folder.py during its lifetime.
class FolderServer {
 public:
  explicit FolderServer(const std::filesystem::path& folder) {
    const std::string command = std::string("exec ") + MULTITETRA_PYTHON + " " +
                                MULTITETRA_SERVE_FOLDER + " " + folder.string();
    output_ = popen(command.c_str(), "r");
    char line[64] = {};
    if (output_ == nullptr || std::fgets(line, sizeof(line), output_) == nullptr) return;
    std::istringstream(line) >> address_ >> process_;
  }
  ~FolderServer() {
    if (process_ > 0) kill(process_, SIGTERM);
    if (output_ != nullptr) pclose(output_);
  }
  FolderServer(const FolderServer&) = delete;
  FolderServer& operator=(const FolderServer&) = delete;
  [[nodiscard]] const std::string& address() const { return address_; }

 private:
  std::FILE* output_ = nullptr;
  std::string address_;
  int process_ = 0;
};

}  // namespace multitetra
