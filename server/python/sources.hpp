// Sources of samples for Python.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "server/dataset/provenance.hpp"
#include "server/volume/volume_source.hpp"

namespace multitetra {

// Collects the notices of a source. Thread-safe.
class NoticeList {
 public:
  void add(const std::string& text) {
    const std::lock_guard lock(mutex_);
    texts_.push_back(text);
  }
  [[nodiscard]] std::vector<std::string> texts() const {
    const std::lock_guard lock(mutex_);
    return texts_;
  }

 private:
  mutable std::mutex mutex_;  // Guards texts_.
  std::vector<std::string> texts_;
};

// A source that is opened in the thread that reads it: a sandboxed reader ends with the thread that
// started it.
struct PythonSource {
  std::function<std::unique_ptr<VolumeSource>()> open;
  std::function<Provenance()> provenance;
  std::string name;  // Of the dataset.
  std::shared_ptr<NoticeList> notices;
};

}  // namespace multitetra
