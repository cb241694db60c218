#include "server/volume/formats/detail/volume_objects.hpp"

#include <utility>

#include "server/store/http_store.hpp"
#include "server/volume/formats/detail/zip_store.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {
namespace {

template <typename Action>
auto as_volume_trouble(const Action& action) {
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
    return as_volume_trouble([&] { return store_->get(key, most); });
  }
  std::optional<std::vector<std::byte>> get_range(const std::string& key, std::uint64_t offset,
                                                  std::uint64_t length) override {
    return as_volume_trouble([&] { return store_->get_range(key, offset, length); });
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

std::shared_ptr<ObjectStore> volume_objects(const std::string& place, bool follow) {
  return std::make_shared<VolumeObjects>(as_volume_trouble([&] {
    if (is_address(place)) return http_store(place, {.follow = follow});
    std::error_code error;
    if (std::filesystem::is_directory(place, error)) return folder_store(place, follow);
    return zip_store(place);
  }));
}

}  // namespace multitetra
