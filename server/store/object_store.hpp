// Named objects: files of a folder, or objects below an address of an HTTP server or S3 bucket.
// Zarr and N5 chunks are read from such stores.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/store/store_error.hpp"

namespace multitetra {

// Safe to use from several threads at once.
class ObjectStore {
 public:
  virtual ~ObjectStore() = default;

  // Returns the whole object, or nullopt if it does not exist. Throws StoreError if it has more
  // than `max_bytes` bytes or the store fails.
  [[nodiscard]] virtual std::optional<std::vector<std::byte>> get(const std::string& key,
                                                                  std::uint64_t max_bytes) = 0;
  // Returns `length` bytes from `offset`, or the last `length` bytes if `offset` is kFromEnd; fewer
  // at the end of the object.
  static constexpr std::uint64_t kFromEnd = ~std::uint64_t{0};
  [[nodiscard]] virtual std::optional<std::vector<std::byte>> get_range(const std::string& key,
                                                                        std::uint64_t offset,
                                                                        std::uint64_t length) = 0;
  // Returns the names below a key that is empty or ends with '/', sorted; none if the store cannot
  // list them, as servers cannot.
  [[nodiscard]] virtual std::vector<std::string> names(const std::string& /*key*/) { return {}; }
  // Returns the object's location for messages.
  [[nodiscard]] virtual std::filesystem::path place(const std::string& key) const = 0;
  // Returns a useful number of concurrent requests.
  [[nodiscard]] virtual std::size_t parallel_requests() const = 0;
};

// Returns the files below a folder. Links that lead out of it and keys with ".." require
// `allow_external_files`.
[[nodiscard]] std::unique_ptr<ObjectStore> folder_store(std::filesystem::path folder,
                                                        bool allow_external_files = true);

// Reads an object of at most 16 MiB as text; nullopt if it does not exist.
[[nodiscard]] std::optional<std::string> text_of(ObjectStore& store, const std::string& key);

}  // namespace multitetra
