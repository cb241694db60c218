// The datasets of `serve`: files and folders of them, which may change while they are served.
//
//   ServedDatasets datasets({"/srv/volumes"}, cache);
//   Server server(datasets.read(), ...);
//   ... server.offer(datasets.read());  // After files came, went or were replaced.
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

// To be used by one thread at a time.
class ServedDatasets {
 public:
  // Files and addresses, and folders, here or in buckets, whose files *.mtd are meant.
  ServedDatasets(const std::vector<std::string>& inputs, std::shared_ptr<SurfaceCache> cache,
                 std::shared_ptr<RemoteFiles> files);

  // All datasets that can be served now. An unchanged file stays open; one that cannot be used is
  // logged and left out, but a dataset that was served under its name stays served. New and removed
  // datasets are logged, too. Throws std::filesystem::filesystem_error or StoreError when a folder
  // cannot be read; then nothing changes.
  [[nodiscard]] CataloguePtr read();

 private:
  struct Input {
    std::string place;
    bool is_folder =
        // A folder of datasets. Determined at the start: a folder that is gone for a while is no
        // file.
        false;
  };
  // Another one under the same name is another file.
  struct Identity {
    dev_t device = 0;
    ino_t inode = 0;
    off_t size = 0;
    std::int64_t modified = 0;  // Nanoseconds.
    // The version of a remote file, from its store.
    std::string version = {};

    friend bool operator==(const Identity&, const Identity&) = default;
  };
  struct Opened {
    Identity identity;
    std::shared_ptr<const SurfaceProvider> source;
  };
  [[nodiscard]] Identity identity_of(const std::string& place) const;
  [[nodiscard]] std::vector<std::string> places() const;
  // Null when it cannot be used, and nothing was served from under its name.
  [[nodiscard]] std::shared_ptr<const SurfaceProvider> source_of(const std::string& place);

  std::vector<Input> inputs_;
  std::shared_ptr<SurfaceCache> cache_;
  std::shared_ptr<RemoteFiles> files_;
  std::shared_ptr<CubeMemoryPool> pool_;
  std::map<std::string, Opened> opened_;
};

}  // namespace multitetra
