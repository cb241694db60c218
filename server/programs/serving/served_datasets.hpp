// The datasets of `serve`: files, and folders whose content may change while they are served.
//
//   ServedDatasets datasets({"/srv/volumes"}, cache);
//   Server server(datasets.read(), ...);
//   ... server.offer(datasets.read(), datasets.is_complete());  // After files were added, removed or replaced.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "server/extraction/surface_extractor.hpp"
#include "server/service/dataset_catalogue.hpp"
#include "server/service/surface_cache.hpp"
#include "server/store/remote_files.hpp"

namespace multitetra {

// Not thread-safe.
class ServedDatasets {
 public:
  // `inputs` are files, addresses, and folders or buckets, which stand for their files *.mtd.
  ServedDatasets(const std::vector<std::string>& inputs, std::shared_ptr<SurfaceCache> cache,
                 std::shared_ptr<RemoteFiles> files, ReadingsSource readings = nullptr);

  // Returns all datasets that can be served now. Unchanged files stay open. A dataset that cannot
  // be read is logged and omitted, or keeps its previous version if it has one. Logs new and
  // removed datasets. Without any effect, throws std::filesystem::filesystem_error or StoreError if
  // a folder cannot be read, and std::runtime_error if all datasets are gone, as from a folder that
  // is no longer mounted.
  [[nodiscard]] CataloguePtr read();
  // Returns whether the last read() has served the current version of every file.
  [[nodiscard]] bool is_complete() const { return is_complete_; }
  // Returns whether the last read() has omitted a dataset because of its store, which may recover.
  [[nodiscard]] bool is_store_failing() const { return is_store_failing_; }

 private:
  struct Input {
    std::string place;
    // Determined at the start, so that a temporarily missing folder is not taken for a file.
    bool is_folder = false;
  };
  // Detects whether a path has another file.
  struct Identity {
    dev_t device = 0;
    ino_t inode = 0;
    off_t size = 0;
    std::int64_t modified = 0;  // In nanoseconds.
    // The version of a remote file, from its store.
    std::string version = {};

    friend bool operator==(const Identity&, const Identity&) = default;
  };
  struct Opened {
    Identity identity;
    std::shared_ptr<const SurfaceProvider> source;
    bool is_served = false;  // Logged so; else another file has its name.
  };
  [[nodiscard]] Identity identity_of(const std::string& place) const;
  [[nodiscard]] std::vector<std::string> dataset_paths() const;
  // Returns null if the dataset cannot be used and no previous version was served.
  [[nodiscard]] Opened* opened(const std::string& place);

  std::vector<Input> inputs_;
  std::shared_ptr<SurfaceCache> cache_;
  std::shared_ptr<RemoteFiles> files_;
  ReadingsSource readings_;
  std::shared_ptr<CubeMemoryPool> pool_;
  std::map<std::string, Opened> opened_;
  bool is_complete_ = true;
  bool is_store_failing_ = false;
};

}  // namespace multitetra
