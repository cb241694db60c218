// Named objects: the files of a folder, or what an HTTP server or an S3 bucket has under an
// address. Chunks of Zarr and N5 lie in such stores, and prepared datasets that are made of
// objects.
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

  // The whole object; nullopt when there is none. Throws StoreError when it has more than `most`
  // bytes or the store fails.
  [[nodiscard]] virtual std::optional<std::vector<std::byte>> get(const std::string& key,
                                                                  std::uint64_t most) = 0;
  // `length` bytes from `offset` on, or the object's last ones when offset is kFromEnd; fewer where
  // the object ends.
  static constexpr std::uint64_t kFromEnd = ~std::uint64_t{0};
  [[nodiscard]] virtual std::optional<std::vector<std::byte>> get_range(const std::string& key,
                                                                        std::uint64_t offset,
                                                                        std::uint64_t length) = 0;
  // For sentences: where the object is.
  [[nodiscard]] virtual std::filesystem::path place(const std::string& key) const = 0;
  // The useful number of concurrent requests.
  [[nodiscard]] virtual std::size_t parallel_requests() const = 0;
};

// The files below a folder. Links that lead out of it are followed only with `follow`, as are keys
// with "..".
[[nodiscard]] std::unique_ptr<ObjectStore> folder_store(std::filesystem::path folder,
                                                        bool follow = true);

// An object as text, at most 16 MiB of it; nullopt when there is none.
[[nodiscard]] std::optional<std::string> text_of(ObjectStore& store, const std::string& key);

}  // namespace multitetra
