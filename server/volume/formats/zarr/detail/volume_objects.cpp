#include "server/volume/formats/zarr/detail/volume_objects.hpp"

#include <utility>

#include "server/store/http_store.hpp"
#include "server/volume/formats/detail/zip_store.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {
namespace {

template <typename Action>
auto rethrow_as_volume_error(const Action& action) {
  try {
    return action();
  } catch (const StoreAccessDenied& refusal) {
    throw InaccessibleObject(refusal.what());
  } catch (const StoreError& error) {
    throw VolumeFileError(error.what());
  }
}

class VolumeObjects : public ObjectStore {
 public:
  explicit VolumeObjects(std::unique_ptr<ObjectStore> store) : store_(std::move(store)) {}

  std::optional<std::vector<std::byte>> get(const std::string& key, std::uint64_t most) override {
    return rethrow_as_volume_error([&] { return store_->get(key, most); });
  }
  std::optional<std::vector<std::byte>> get_range(const std::string& key, std::uint64_t offset,
                                                  std::uint64_t length) override {
    return rethrow_as_volume_error([&] { return store_->get_range(key, offset, length); });
  }
  [[nodiscard]] std::vector<std::string> names(const std::string& key) override {
    return rethrow_as_volume_error([&] { return store_->names(key); });
  }
  [[nodiscard]] std::filesystem::path place(const std::string& key) const override {
    return store_->place(key);
  }
  [[nodiscard]] std::size_t parallel_requests() const override {
    return store_->parallel_requests();
  }

 private:
  std::unique_ptr<ObjectStore> store_;
};

}  // namespace

std::shared_ptr<ObjectStore> volume_objects(const std::string& place, bool allow_external_files) {
  return std::make_shared<VolumeObjects>(rethrow_as_volume_error([&] {
    if (is_address(place)) return http_store(place, {.allow_other_hosts = allow_external_files});
    std::error_code error;
    if (std::filesystem::is_directory(place, error))
      return folder_store(place, allow_external_files);
    return zip_store(place);
  }));
}

}  // namespace multitetra
