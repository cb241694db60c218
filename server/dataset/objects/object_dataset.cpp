#include "server/dataset/objects/object_dataset.hpp"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "server/dataset/byte_source.hpp"
#include "server/dataset/objects/object_structure.hpp"
#include "server/dataset/prepared_bricks.hpp"
#include "server/dataset/small_sections.hpp"

namespace multitetra {
namespace {

// Made by whoever asks first. Trouble in making is that one's, and the next one tries again.
template <typename T>
class MadeOnce {
 public:
  ~MadeOnce() { delete made_.load(); }
  MadeOnce() = default;
  MadeOnce(const MadeOnce&) = delete;
  MadeOnce& operator=(const MadeOnce&) = delete;

  template <typename Make>
  const T& get(const Make& make) const {
    if (const T* const made = made_.load(std::memory_order_acquire)) return *made;
    const std::lock_guard lock(mutex_);
    if (const T* const made = made_.load(std::memory_order_acquire)) return *made;
    const T* const made = new T(make());
    made_.store(made, std::memory_order_release);
    return *made;
  }

 private:
  mutable std::mutex mutex_;  // Whoever makes it holds it.
  mutable std::atomic<const T*> made_ = nullptr;
};

// What all sources of one dataset share.
struct OpenedObjects {
  OpenedObjects(const std::string& place, std::shared_ptr<ObjectCache> cache)
      : keeps(std::move(cache)),
        reader(keeps->place(place), keeps),
        structure(reader.structure()) {}

  [[nodiscard]] const SampleIndex& sample_index() const {
    return sample_index_.get([&] { return reader.sample_index(structure); });
  }
  [[nodiscard]] std::span<const std::byte> coarse() const {
    return coarse_.get([&] {
      return reader.section(structure.manifest.first, structure.parts.coarse,
                            section_names::kCoarse);
    });
  }
  [[nodiscard]] std::span<const std::byte> ranges() const {
    return ranges_.get([&] {
      return reader.section(structure.manifest.later, structure.parts.ranges,
                            section_names::kRanges);
    });
  }

  const std::shared_ptr<ObjectCache> keeps;
  const ObjectReader reader;
  const ObjectStructure structure;

 private:
  MadeOnce<SampleIndex> sample_index_;
  MadeOnce<std::vector<std::byte>> coarse_;
  MadeOnce<std::vector<std::byte>> ranges_;
};

// Bricks that lie in objects.
class ObjectBricks : public BrickSource {
 public:
  [[nodiscard]] KeptBytes brick(std::size_t index) const final {
    const BrickPlace expected = expected_place(index);
    if (expected.size == 0) return {};
    const BrickInObject at = in_object(index);
    if (!verified_.contains(index)) look_ahead(at.object);
    ObjectBytes object = opened_->reader.cache().get(opened_->reader.place(), name(at.object));
    const auto bytes = std::span<const std::byte>(*object).subspan(at.offset, at.size);
    if (!verified_.contains(index)) {
      if (const auto whole = check_brick(section_, index, bytes, expected.checksum, type_);
          !whole) {
        throw DatasetFileError(opened_->reader.place().place, whole.error().text);
      }
      verified_.add(index);
    }
    return {bytes, std::move(object)};
  }

  [[nodiscard]] bool is_far() const final { return opened_->reader.place().is_far; }

  void will_need(std::span<const std::size_t> bricks) const final {
    try {
      opened_->reader.cache().will_need(opened_->reader.place(), names_of(bricks));
    } catch (const std::exception&) {  // NOLINT: told to whoever asks for the bricks.
    }
  }
  [[nodiscard]] std::uint64_t bytes_to_fetch(std::span<const std::size_t> bricks) const final {
    return is_far() ? opened_->reader.cache().missing_bytes(names_of(bricks)) : 0;
  }

 protected:
  ObjectBricks(std::shared_ptr<const OpenedObjects> opened, const char* section, std::size_t bricks,
               std::size_t objects, std::optional<SampleType> type)
      : opened_(std::move(opened)),
        section_(section),
        type_(type),
        objects_(objects),
        verified_(bricks) {}

  [[nodiscard]] const OpenedObjects& opened() const { return *opened_; }

 private:
  [[nodiscard]] virtual BrickPlace expected_place(std::size_t brick) const = 0;
  [[nodiscard]] virtual BrickInObject in_object(std::size_t brick) const = 0;
  [[nodiscard]] virtual const ObjectName& name(std::size_t object) const = 0;
  // Called when an object is looked at that may not be here.
  virtual void look_ahead(std::size_t object) const { (void)object; }

  // The objects of the bricks, each once, in the order in which they are needed first.
  [[nodiscard]] std::vector<ObjectName> names_of(std::span<const std::size_t> bricks) const {
    std::vector<bool> is_named(objects_);
    std::vector<ObjectName> names;
    for (const std::size_t brick : bricks) {
      if (expected_place(brick).size == 0) continue;
      const std::size_t object = in_object(brick).object;
      if (is_named[object]) continue;
      is_named[object] = true;
      names.push_back(name(object));
    }
    return names;
  }

  const std::shared_ptr<const OpenedObjects> opened_;
  const std::string section_;
  const std::optional<SampleType> type_;
  const std::size_t objects_;
  mutable ConcurrentSet verified_;
};

class SamplesInObjects final : public ObjectBricks {
 public:
  explicit SamplesInObjects(const std::shared_ptr<const OpenedObjects>& opened)
      : ObjectBricks(
            opened, section_names::kSamples, opened->structure.sample_objects.bricks().size(),
            opened->structure.sample_objects.size(), opened->structure.metadata.info.type) {}

 private:
  [[nodiscard]] BrickPlace expected_place(std::size_t brick) const override {
    return {.size = 1, .checksum = opened().sample_index().checksums[brick]};  // Never empty.
  }
  [[nodiscard]] BrickInObject in_object(std::size_t brick) const override {
    return opened().structure.sample_objects.place(brick);
  }
  [[nodiscard]] const ObjectName& name(std::size_t object) const override {
    return opened().sample_index().names[object];
  }
};

class SpectrumInObjects final : public ObjectBricks {
 public:
  explicit SpectrumInObjects(const std::shared_ptr<const OpenedObjects>& opened)
      : ObjectBricks(opened, section_names::kSpectrum, opened->structure.spectrum_index.size(),
                     opened->structure.spectrum_objects.size(), std::nullopt),
        is_ahead_(opened->structure.spectrum_objects.size()) {}

 private:
  [[nodiscard]] BrickPlace expected_place(std::size_t brick) const override {
    return opened().structure.spectrum_index[brick];
  }
  [[nodiscard]] BrickInObject in_object(std::size_t brick) const override {
    return opened().structure.spectrum_objects.place(brick);
  }
  [[nodiscard]] const ObjectName& name(std::size_t object) const override {
    return opened().structure.spectrum_names[object];
  }
  // Behind the first object, which has the coarsest levels, whoever wants one wants those near it.
  void look_ahead(std::size_t object) const override {
    constexpr std::size_t kAhead = 8;
    const auto& names = opened().structure.spectrum_names;
    if (!is_far() || object == 0 || is_ahead_[object].exchange(true)) return;
    const std::size_t count = std::min(kAhead, names.size() - object);
    opened().reader.cache().will_need(opened().reader.place(),
                                      std::span(names).subspan(object, count));
  }

  mutable std::vector<std::atomic<bool>> is_ahead_;  // By object: those behind it were asked for.
};

}  // namespace

bool is_object_dataset(const std::string& place) {
  std::error_code ignored;
  return is_address(place) ||
         std::filesystem::is_regular_file(std::filesystem::path(place) / kManifestName, ignored);
}

bool is_folder_of_datasets(const std::string& place) {
  std::error_code ignored;
  return !is_object_dataset(place) && std::filesystem::is_directory(place, ignored);
}

std::vector<std::filesystem::path> datasets_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> found;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const bool is_file = entry.path().extension() == ".mtd";
    if (is_file || is_object_dataset(entry.path().string())) found.push_back(entry.path());
  }
  std::sort(found.begin(), found.end());
  return found;
}

DatasetPtr open_objects(const std::string& place, std::shared_ptr<ObjectCache> cache) {
  const auto opened = std::make_shared<const OpenedObjects>(place, std::move(cache));
  const ObjectStructure& structure = opened->structure;
  DatasetInfo info = structure.metadata.info;
  info.content_id = content_id_of(structure.manifest.sections);
  check_small_sections(place, info, structure.parts.coarse.size, structure.parts.ranges.size);
  return std::make_shared<const PreparedVolume>(
      PreparedVolume{.info = info,
                     .samples = std::make_shared<const SamplesInObjects>(opened),
                     .coarse = BytesOnDemand([opened] { return opened->coarse(); }),
                     .ranges = BytesOnDemand([opened] { return opened->ranges(); }),
                     .spectrum = {.layout = SpectrumLayout(info),
                                  .bins = bins_of(place, structure.bins),
                                  .voxel = static_cast<float>(voxel_length(info)),
                                  .bricks = std::make_shared<const SpectrumInObjects>(opened)},
                     .owner = opened});
}

DatasetPtr open_any_dataset(const std::string& place, std::shared_ptr<ObjectCache> cache) {
  if (!is_object_dataset(place)) return open_dataset(place);
  if (!cache) cache = std::make_shared<ObjectCache>();
  return open_objects(place, std::move(cache));
}

}  // namespace multitetra
