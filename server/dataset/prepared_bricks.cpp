#include "server/dataset/prepared_bricks.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

namespace multitetra {
namespace {

// The first preview needs only the beginning of a remote file, which is fetched in one request
// after that of the opening. Beyond it, this many bytes from a brick on are prefetched.
constexpr std::uint64_t kPreviewBytes = std::uint64_t{512} << 10;
constexpr std::uint64_t kPrefetchBytes = std::uint64_t{1} << 20;

// Marks the keys of constant bricks, which are shared by value.
constexpr std::uint64_t kConstantKey = std::uint64_t{1} << 63;

}  // namespace

PreparedBricks::PreparedBricks(BrickFile file, const char* section, std::size_t size,
                               std::optional<SampleType> type)
    : file_(std::move(file)),
      section_(file_.structure->section(section)),
      size_(size),
      type_(type),
      owner_(*file_.cache),
      verified_(file_.source->is_remote() ? 0 : size) {}

RetainedBytes PreparedBricks::brick(std::size_t number) const {
  assert(number < size_);
  file_.source->check();
  reads_.fetch_add(1, std::memory_order_relaxed);
  const BrickPlace& place = index()[number];
  if (place.size() == 0) return {};  // Only bricks of the spectrum are empty.
  if (place.codec() == BrickCodec::kConstant && type_) return constant(number, place);
  if (place.codec() == BrickCodec::kRaw && !is_remote()) return in_place(number, place);
  const MemoryCache::Key key = owner_.key(number);
  CachedBytes bytes = file_.cache->find(key);
  if (!bytes) {
    bytes = unpacked(number, place);
    file_.cache->put(key, bytes);
  }
  const std::span<const std::byte> span = *bytes;
  return {span, std::move(bytes)};
}

PackedBrick PreparedBricks::packed(std::size_t number) const {
  file_.source->check();
  const BrickPlace& place = index()[number];
  (void)unpacked(number, place);  // Verifies it.
  const FileRange range = range_of(place);
  const RetainedBytes bytes = file_.source->bytes(range.offset, range.size);
  return {.codec = place.codec(), .bytes = {bytes.begin(), bytes.end()}};
}

RetainedBytes PreparedBricks::in_place(std::size_t number, const BrickPlace& place) const {
  const FileRange range = range_of(place);
  RetainedBytes bytes = file_.source->bytes(range.offset, range.size);
  if (verified_.contains(number)) return bytes;
  (void)unpacked(number, place);
  verified_.add(number);
  return bytes;
}

// Constant bricks of the same value share their bytes: those of the largest one accessed so far.
RetainedBytes PreparedBricks::constant(std::size_t number, const BrickPlace& place) const {
  const FileRange range = range_of(place);
  std::uint32_t value = 0;
  const std::size_t size = bytes_of(number);
  CachedBytes bytes;
  if (range.size == static_cast<std::uint64_t>(bytes_per_sample(*type_))) {
    const RetainedBytes packed = file_.source->bytes(range.offset, range.size);
    std::copy(packed.begin(), packed.end(), std::as_writable_bytes(std::span(&value, 1)).begin());
    if (brick_checksum({packed.data(), packed.size()}) == place.checksum) {
      bytes = file_.cache->find(owner_.key(kConstantKey | value));
    }
  }
  if (!bytes || bytes->size() < size) {
    bytes = unpacked(number, place);
    file_.cache->put(owner_.key(kConstantKey | value), bytes);
  }
  const auto span = std::span<const std::byte>(*bytes).first(size);
  return {span, std::move(bytes)};
}

// Bytes of a remote file that are damaged are fetched once more.
CachedBytes PreparedBricks::unpacked(std::size_t number, const BrickPlace& place) const {
  const FileRange range = range_of(place);
  prefetch_following(place);
  for (int attempt = 0;; ++attempt) {
    const RetainedBytes packed = file_.source->bytes(range.offset, range.size);
    auto bytes = std::make_shared<std::vector<std::byte>>();
    const auto whole = unpack_checked(section_.name, number, place, {packed.data(), packed.size()},
                                      type_, type_ ? bytes_of(number) : 0, *bytes);
    if (whole) return bytes;
    if (!is_remote() || attempt > 0) throw DatasetFileError(file_.place, whole.error().text);
    file_.source->invalidate(range);
  }
}

std::vector<FileRange> PreparedBricks::ranges_of(std::span<const std::size_t> bricks) const {
  const std::span<const BrickPlace> places = index();
  std::vector<FileRange> ranges;
  ranges.reserve(bricks.size());
  for (const std::size_t brick : bricks) ranges.push_back(range_of(places[brick]));
  return ranges;
}

void PreparedBricks::prefetch(std::span<const std::size_t> bricks) const {
  if (!is_remote()) return;
  try {
    file_.source->prefetch(ranges_of(bricks));
  } catch (const std::exception&) {  // NOLINT: the read that needs the index reports the error.
  }
}

std::uint64_t PreparedBricks::bytes_to_fetch(std::span<const std::size_t> bricks) const {
  return is_remote() ? file_.source->bytes_to_fetch(ranges_of(bricks)) : 0;
}

void PreparedBricks::prefetch_following(const BrickPlace& place) const {
  const FileRange range = range_of(place);
  if (type_ || !is_remote() || file_.source->bytes_to_fetch({&range, 1}) == 0) return;
  if (range.offset < kPreviewBytes) {
    const std::uint64_t end = std::min(kPreviewBytes, file_.source->size());
    (void)file_.source->bytes(range.offset, static_cast<std::size_t>(end - range.offset));
    return;
  }
  const FileRange ahead{
      .offset = range.offset,
      .size = std::min(kPrefetchBytes, section_.offset + section_.size - range.offset)};
  file_.source->prefetch({&ahead, 1});
}

// ---- samples

SampleBricks::SampleBricks(const BrickFile& file)
    : PreparedBricks(file, section_names::kSamples,
                     BrickLayout(file.structure->metadata.info.dims).size(),
                     file.structure->metadata.info.type),
      layout_(file.structure->metadata.info.dims) {}

std::span<const BrickPlace> SampleBricks::index() const {
  std::call_once(is_read_, [this] {
    auto index = decode_sample_index(*file().source, *file().structure);
    if (!index) throw DatasetFileError(file().place, index.error().text);
    index_ = *std::move(index);
  });
  return index_;
}

std::size_t SampleBricks::bytes_of(std::size_t number) const {
  return layout_.volume(layout_.at(number)) *
         static_cast<std::size_t>(bytes_per_sample(file().structure->metadata.info.type));
}

// ---- spectrum

SpectrumBricks::SpectrumBricks(const BrickFile& file)
    : PreparedBricks(file, section_names::kSpectrum, file.structure->spectrum_index.size(),
                     std::nullopt) {}

}  // namespace multitetra
