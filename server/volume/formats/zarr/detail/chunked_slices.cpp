#include "server/volume/formats/zarr/detail/chunked_slices.hpp"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <mutex>
#include <utility>

#include "common/base/on_threads.hpp"

namespace multitetra {
namespace {

constexpr std::uint64_t kMaxLayerBytes = std::uint64_t{1} << 30;
// Limit for chunks and shard indices in progress; one chunk is always allowed.
constexpr std::uint64_t kMaxWorkBytes = std::uint64_t{1} << 29;

// Reads the chunks of an array.
class Chunks {
 public:
  Chunks(std::shared_ptr<ObjectStore> store, std::string path, ArrayLayout layout)
      : store_(std::move(store)), path_(std::move(path)), layout_(std::move(layout)) {}

  [[nodiscard]] const ArrayLayout& layout() const { return layout_; }
  [[nodiscard]] std::filesystem::path place() const { return store_->place(path_); }
  // Returns the number of chunks to fetch at once, limited by the memory of a chunk, packed and
  // unpacked, and of the index of its shard.
  [[nodiscard]] std::size_t parallel_requests() const {
    const std::uint64_t index = layout_.shards ? 2 * shard_index_bytes(layout_) : 0;
    const std::uint64_t each = 3 * std::uint64_t{layout_.chunk_bytes()} + index;
    return std::clamp<std::size_t>(kMaxWorkBytes / each, 1, store_->parallel_requests());
  }

  // Returns the numbers of a chunk; nullopt if it is missing.
  std::optional<std::vector<std::byte>> get(const std::vector<std::int64_t>& chunk) {
    return layout_.shards ? from_shard(chunk) : whole_object(chunk);
  }

  // Drops the indices of shards.
  void forget() {
    const std::lock_guard lock(mutex_);
    shards_.clear();
  }

 private:
  struct Shard {
    std::vector<std::int64_t> object;
    std::once_flag read;
    std::vector<ShardEntry> entries;  // Empty if the shard is missing.
  };

  [[nodiscard]] std::uint64_t max_stored_bytes() const {
    return 2 * layout_.chunk_bytes() + (std::uint64_t{1} << 16);
  }

  [[nodiscard]] std::vector<std::byte> decoded(const std::string& key,
                                               std::span<const std::byte> stored,
                                               const std::string& what) const {
    auto chunk = decode_chunk(layout_, stored);
    if (chunk) return *std::move(chunk);
    fail_damaged(store_->place(key), what + " cannot be decoded: " + chunk.error().text);
  }

  std::optional<std::vector<std::byte>> whole_object(const std::vector<std::int64_t>& chunk) {
    const std::string key = path_ + layout_.key(chunk);
    const auto stored = store_->get(key, max_stored_bytes());
    if (!stored) return std::nullopt;
    return decoded(key, *stored, "this chunk");
  }

  std::optional<std::vector<std::byte>> from_shard(const std::vector<std::int64_t>& chunk) {
    std::vector<std::int64_t> object(chunk.size());
    std::size_t inside = 0;
    for (std::size_t d = 0; d < chunk.size(); ++d) {
      const std::int64_t count = layout_.shards->chunk_counts[d];
      object[d] = chunk[d] / count;
      inside =
          inside * static_cast<std::size_t>(count) + static_cast<std::size_t>(chunk[d] % count);
    }
    const std::string key = path_ + layout_.key(object);
    const std::shared_ptr<Shard> shard = shard_of(object);
    std::call_once(shard->read, [&] { shard->entries = index_of(key); });
    if (shard->entries.empty()) return std::nullopt;
    const ShardEntry entry = shard->entries[inside];
    if (entry.offset == kNoChunk && entry.length == kNoChunk) return std::nullopt;
    const std::string what = "the chunk " + std::to_string(inside) + " of this shard";
    if (entry.length > max_stored_bytes()) {
      fail_damaged(store_->place(key),
                   what + " has a declared size of " + std::to_string(entry.length) + " bytes");
    }
    const auto stored = store_->get_range(key, entry.offset, entry.length);
    if (!stored || stored->size() != entry.length) {
      fail_incomplete(store_->place(key), what + " is beyond its end");
    }
    return decoded(key, *stored, what);
  }

  // Chunks are requested shard by shard, so few indices are kept: those in use, and one more.
  std::shared_ptr<Shard> shard_of(const std::vector<std::int64_t>& object) {
    const std::lock_guard lock(mutex_);
    const auto found = std::find_if(shards_.begin(), shards_.end(),
                                    [&](const auto& shard) { return shard->object == object; });
    std::shared_ptr<Shard> shard;
    if (found != shards_.end()) {
      shard = *found;
      shards_.erase(found);
    } else {
      shard = std::make_shared<Shard>();
      shard->object = object;
      if (shards_.size() > parallel_requests()) shards_.erase(shards_.begin());
    }
    shards_.push_back(shard);
    return shard;
  }

  [[nodiscard]] std::vector<ShardEntry> index_of(const std::string& key) const {
    const std::size_t size = shard_index_bytes(layout_);
    const std::uint64_t offset = layout_.shards->index_at_end ? ObjectStore::kFromEnd : 0;
    const auto stored = store_->get_range(key, offset, size);
    if (!stored) return {};
    auto entries = decode_shard_index(layout_, *stored);
    if (entries) return *std::move(entries);
    fail_damaged(store_->place(key),
                 "the index of this shard cannot be decoded: " + entries.error().text);
  }

  std::shared_ptr<ObjectStore> store_;
  std::string path_;
  ArrayLayout layout_;
  std::mutex mutex_;                            // Guards shards_.
  std::vector<std::shared_ptr<Shard>> shards_;  // Most recently used last.
};

class ChunkedSlices : public StoredSlices {
 public:
  ChunkedSlices(std::shared_ptr<ObjectStore> store, std::string path, ArrayLayout layout,
                VolumeInArray volume)
      : chunks_(std::move(store), std::move(path), std::move(layout)), volume_(std::move(volume)) {
    const ArrayLayout& array = chunks_.layout();
    std::size_t stride = 1;
    strides_.resize(array.shape.size());
    for (std::size_t i = array.order.size(); i-- > 0;) {
      strides_[array.order[i]] = stride;
      stride *= static_cast<std::size_t>(array.chunk[array.order[i]]);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!volume_.axes[axis]) continue;
      dims_[axis] = array.shape[*volume_.axes[axis]];
      chunk_[axis] = array.chunk[*volume_.axes[axis]];
    }
    slice_bytes_ = static_cast<std::size_t>(dims_[0] * dims_[1]) * bytes_of(array.type);
    is_counted_.resize(static_cast<std::size_t>((dims_[2] + chunk_[2] - 1) / chunk_[2]));
  }

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    const auto end = static_cast<std::int64_t>(first + count);
    for (auto z = static_cast<std::int64_t>(first); z < end;) {
      const std::int64_t layer = z / chunk_[2];
      const std::int64_t layer_end = std::min((layer + 1) * chunk_[2], dims_[2]);
      const std::int64_t stop = std::min(end, layer_end);
      load(layer, z, stop, layer_end);
      const auto slices = static_cast<std::size_t>(stop - z);
      std::memcpy(into, loaded_.data() + static_cast<std::size_t>(z - begin_) * slice_bytes_,
                  slices * slice_bytes_);
      into += slices * slice_bytes_;
      z = stop;
    }
  }

  [[nodiscard]] std::vector<std::string> findings() const override {
    if (chunks_missing_ == 0) return {};
    return {"'" + chunks_.place().string() + "': " + std::to_string(chunks_missing_) + " of " +
            std::to_string(chunks_seen_) +
            " chunks are missing; their samples have the array's fill value."};
  }

 private:
  // Loads the slices z to stop - 1 of this layer of chunks unless they are in loaded_.
  void load(std::int64_t layer, std::int64_t z, std::int64_t stop, std::int64_t layer_end) {
    if (z >= begin_ && stop <= end_) return;
    const std::int64_t layer_begin = layer * chunk_[2];
    const bool whole =
        static_cast<std::uint64_t>(layer_end - layer_begin) * slice_bytes_ <= kMaxLayerBytes;
    begin_ = whole ? layer_begin : z;
    end_ = begin_;  // Nothing is valid until all of it is loaded.
    const std::int64_t new_end = whole ? layer_end : stop;
    loaded_.resize(static_cast<std::size_t>(new_end - begin_) * slice_bytes_);
    chunks_.forget();
    const std::vector<std::array<std::int64_t, 2>> columns = columns_by_shard();
    std::atomic<std::uint64_t> missing = 0;
    // Not a thread pool, which would not survive a fork.
    try {
      on_threads(chunks_.parallel_requests(), columns.size(), [&](std::size_t i) {
        if (!place({columns[i][0], columns[i][1], layer}, new_end)) ++missing;
      });
    } catch (const StoreError& problem) {
      throw VolumeFileError(problem.what());
    }
    const auto number = static_cast<std::size_t>(layer);
    if (!is_counted_[number]) {
      is_counted_[number] = true;
      chunks_seen_ += columns.size();
      chunks_missing_ += missing;
    }
    end_ = new_end;
  }

  // Returns the chunks of a layer along x and y, grouped by shard.
  [[nodiscard]] std::vector<std::array<std::int64_t, 2>> columns_by_shard() const {
    std::array<std::int64_t, 2> counts{};
    std::array<std::int64_t, 2> of_shard = {1, 1};
    for (std::size_t axis = 0; axis < 2; ++axis) {
      counts[axis] = (dims_[axis] + chunk_[axis] - 1) / chunk_[axis];
      const auto& shards = chunks_.layout().shards;
      if (shards && volume_.axes[axis]) of_shard[axis] = shards->chunk_counts[*volume_.axes[axis]];
    }
    std::vector<std::array<std::int64_t, 2>> columns;
    for (std::int64_t y = 0; y < counts[1]; ++y) {
      for (std::int64_t x = 0; x < counts[0]; ++x) columns.push_back({x, y});
    }
    const auto shard_of = [&](const std::array<std::int64_t, 2>& column) {
      return std::pair(column[1] / of_shard[1], column[0] / of_shard[0]);
    };
    std::stable_sort(columns.begin(), columns.end(),
                     [&](const auto& a, const auto& b) { return shard_of(a) < shard_of(b); });
    return columns;
  }

  // Fetches the chunk with these indices along x, y, z and copies its part to loaded_. Returns
  // false if it is missing.
  bool place(const std::array<std::int64_t, 3>& number, std::int64_t new_end) {
    const ArrayLayout& array = chunks_.layout();
    std::vector<std::int64_t> chunk(array.shape.size());
    std::size_t base = 0;
    for (std::size_t d = 0; d < chunk.size(); ++d) {
      chunk[d] = volume_.at[d] / array.chunk[d];
      base += static_cast<std::size_t>(volume_.at[d] % array.chunk[d]) * strides_[d];
    }
    std::array<std::size_t, 3> stride{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto d = volume_.axes[axis];
      if (!d) continue;
      chunk[*d] = number[axis];
      base -= static_cast<std::size_t>(volume_.at[*d] % array.chunk[*d]) * strides_[*d];
      stride[axis] = strides_[*d];
    }
    const auto numbers = chunks_.get(chunk);
    const std::int64_t x0 = number[0] * chunk_[0];
    const std::int64_t y0 = number[1] * chunk_[1];
    const std::int64_t z0 = number[2] * chunk_[2];
    const auto row = static_cast<std::size_t>(std::min(chunk_[0], dims_[0] - x0));
    for (std::int64_t z = std::max(z0, begin_); z < std::min(z0 + chunk_[2], new_end); ++z) {
      for (std::int64_t y = y0; y < std::min(y0 + chunk_[1], dims_[1]); ++y) {
        std::byte* const to = loaded_.data() + static_cast<std::size_t>(z - begin_) * slice_bytes_ +
                              static_cast<std::size_t>(y * dims_[0] + x0) * width();
        const std::size_t from = base + static_cast<std::size_t>(z - z0) * stride[2] +
                                 static_cast<std::size_t>(y - y0) * stride[1];
        copy_row(numbers ? numbers->data() + from * width() : nullptr, stride[0], row, to);
      }
    }
    return numbers.has_value();
  }

  void copy_row(const std::byte* from, std::size_t stride, std::size_t count, std::byte* to) const {
    if (from != nullptr && stride == 1) {
      std::memcpy(to, from, count * width());
      return;
    }
    for (std::size_t i = 0; i < count; ++i) {
      std::memcpy(to + i * width(),
                  from == nullptr ? chunks_.layout().fill.data() : from + i * stride * width(),
                  width());
    }
  }

  [[nodiscard]] std::size_t width() const { return bytes_of(chunks_.layout().type); }

  Chunks chunks_;
  VolumeInArray volume_;
  std::vector<std::size_t> strides_;  // Strides of the dimensions in a chunk, in numbers.
  std::array<std::int64_t, 3> dims_ = {1, 1, 1};
  std::array<std::int64_t, 3> chunk_ = {1, 1, 1};
  std::size_t slice_bytes_ = 0;
  std::vector<std::byte> loaded_;  // The slices begin_ to end_ - 1.
  std::int64_t begin_ = 0;
  std::int64_t end_ = 0;
  std::vector<bool> is_counted_;  // Layers whose missing chunks were counted.
  std::uint64_t chunks_seen_ = 0;
  std::uint64_t chunks_missing_ = 0;
};

}  // namespace

std::unique_ptr<StoredSlices> chunked_slices(std::shared_ptr<ObjectStore> store, std::string path,
                                             ArrayLayout layout, VolumeInArray volume) {
  return std::make_unique<ChunkedSlices>(std::move(store), std::move(path), std::move(layout),
                                         std::move(volume));
}

}  // namespace multitetra
