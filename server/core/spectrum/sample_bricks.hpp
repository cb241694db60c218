// The sample layout of a prepared dataset: bricks of 16 samples a side, so that reading one place
// touches little of the file.
//
// Bricks are ordered x fastest, then y, then z, and so are the samples in a brick. Bricks at the
// upper ends of the data are cut off, not padded: the bricks are a permutation of the samples, and
// bricks with the same z are one contiguous layer.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <utility>

namespace multitetra {

// Bytes that remain valid while this object or a copy lives; its span does not retain them.
class RetainedBytes {
 public:
  RetainedBytes() = default;
  // Without an owner, the bytes remain valid as long as their source.
  RetainedBytes(std::span<const std::byte> bytes,
                std::shared_ptr<const void> owner = nullptr)  // NOLINT
      : bytes_(bytes), owner_(std::move(owner)) {}

  [[nodiscard]] const std::byte* data() const { return bytes_.data(); }
  [[nodiscard]] std::size_t size() const { return bytes_.size(); }
  [[nodiscard]] bool empty() const { return bytes_.empty(); }
  [[nodiscard]] auto begin() const { return bytes_.begin(); }
  [[nodiscard]] auto end() const { return bytes_.end(); }
  [[nodiscard]] std::byte operator[](std::size_t index) const { return bytes_[index]; }

 private:
  std::span<const std::byte> bytes_;
  std::shared_ptr<const void> owner_;
};

// Parts that are read one at a time. Thread-safe.
class BrickSource {
 public:
  virtual ~BrickSource() = default;
  // Returns the bytes of brick `index`. Throws if they are damaged or unavailable.
  [[nodiscard]] virtual RetainedBytes brick(std::size_t index) const = 0;
  // Announces that these bricks will be read soon, in this order, so that a remote source can
  // prefetch them. Does not block and never throws.
  virtual void prefetch(std::span<const std::size_t> bricks) const { (void)bricks; }
  // Returns the bytes that must be fetched from a remote store to read these bricks.
  [[nodiscard]] virtual std::uint64_t bytes_to_fetch(std::span<const std::size_t> bricks) const {
    (void)bricks;
    return 0;
  }
  // Returns whether prefetch() has an effect, so that finding the needed bricks pays off.
  [[nodiscard]] virtual bool is_remote() const { return false; }
};

// Bytes that are loaded as a whole on first use and stay loaded.
class LazyBytes {
 public:
  using Fetch = std::function<std::span<const std::byte>()>;

  LazyBytes() = default;
  LazyBytes(std::span<const std::byte> bytes) : bytes_(bytes) {}  // NOLINT: they are there.
  // `fetch` must be thread-safe, return the same bytes each time, and throw if unavailable.
  explicit LazyBytes(Fetch fetch) : fetch_(std::move(fetch)) {}

  [[nodiscard]] std::span<const std::byte> bytes() const { return fetch_ ? fetch_() : bytes_; }

 private:
  std::span<const std::byte> bytes_;
  Fetch fetch_;
};

using GridCounts = std::array<std::int32_t, 3>;  // Along x, y, z.

// Divides a box of `dims` items into bricks of `side` items.
class BrickLayout {
 public:
  static constexpr std::int32_t kSampleSide = 16;  // Samples along a side of a brick of samples.

  // Requires dims >= 1 each.
  explicit constexpr BrickLayout(const GridCounts& dims, std::int32_t side = kSampleSide)
      : dims_(dims), side_(side) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      counts_[axis] = (dims[axis] + side - 1) / side;
    }
  }

  [[nodiscard]] constexpr const GridCounts& dims() const { return dims_; }      // Items.
  [[nodiscard]] constexpr const GridCounts& counts() const { return counts_; }  // Bricks.
  [[nodiscard]] constexpr std::int32_t side() const { return side_; }
  [[nodiscard]] constexpr std::size_t size() const {  // Number of bricks.
    return static_cast<std::size_t>(counts_[0]) * static_cast<std::size_t>(counts_[1]) *
           static_cast<std::size_t>(counts_[2]);
  }
  [[nodiscard]] constexpr std::size_t index(const GridCounts& brick) const {
    return static_cast<std::size_t>(brick[0]) +
           static_cast<std::size_t>(counts_[0]) *
               (static_cast<std::size_t>(brick[1]) +
                static_cast<std::size_t>(counts_[1]) * static_cast<std::size_t>(brick[2]));
  }
  [[nodiscard]] constexpr GridCounts at(std::size_t index) const {
    const auto x = static_cast<std::size_t>(counts_[0]);
    const auto y = static_cast<std::size_t>(counts_[1]);
    return {static_cast<std::int32_t>(index % x), static_cast<std::int32_t>(index / x % y),
            static_cast<std::int32_t>(index / x / y)};
  }
  // Returns the items along each axis of a brick: `side`, or fewer at the upper ends.
  [[nodiscard]] constexpr GridCounts extent(const GridCounts& brick) const {
    GridCounts extent{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      extent[axis] = std::min(side_, dims_[axis] - side_ * brick[axis]);
    }
    return extent;
  }
  // Returns the number of items in a brick.
  [[nodiscard]] constexpr std::size_t volume(const GridCounts& brick) const {
    const GridCounts e = extent(brick);
    return static_cast<std::size_t>(e[0]) * static_cast<std::size_t>(e[1]) *
           static_cast<std::size_t>(e[2]);
  }
  // Returns the number of items in all bricks before this one.
  [[nodiscard]] constexpr std::uint64_t offset(const GridCounts& brick) const {
    const GridCounts e = extent(brick);
    const auto u = [](std::int32_t value) { return static_cast<std::uint64_t>(value); };
    const std::uint64_t row = u(dims_[0]);
    const std::uint64_t slice = row * u(dims_[1]);
    return u(side_) * (u(brick[2]) * slice + u(e[2]) * (u(brick[1]) * row + u(e[1]) * u(brick[0])));
  }

 private:
  GridCounts dims_;
  GridCounts counts_{};
  std::int32_t side_;
};

}  // namespace multitetra
