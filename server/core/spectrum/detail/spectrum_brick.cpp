#include "server/core/spectrum/detail/spectrum_brick.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "server/core/spectrum/detail/error_codes.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kMaskWords = SpectrumLayout::kPoints / 64;
constexpr std::size_t kMaskBytes = 8 * kMaskWords;
constexpr std::size_t kHeadBytes = 4;

template <typename Number>
void append(std::vector<std::byte>& bytes, Number number) {
  const auto* const first = reinterpret_cast<const std::byte*>(&number);
  bytes.insert(bytes.end(), first, first + sizeof(number));
}

template <typename Number>
Number number_at(std::span<const std::byte> bytes, std::size_t offset) {
  Number number;
  std::memcpy(&number, bytes.data() + offset, sizeof(number));
  return number;
}

tl::unexpected<Error> damaged(const char* what) {
  return fail(ErrorCode::kDamagedData, std::string("A brick of the error spectrum ") + what + ".");
}

}  // namespace

void SpectrumBrickBuilder::add(std::size_t point, const CurveBlock* blocks, CurveLayer::Curve curve,
                               float voxel) {
  const ErrorCodes& codes = error_codes();
  const float per_voxel = (1 + 0x1p-20F) / voxel;  // Rounded up.
  const std::size_t offset = codes_.size();
  int first = -1;
  int end = 0;
  for (int bin = 0; bin < 4 * curve.count; ++bin) {
    const CurveBlock& block = blocks[bin / 4];
    const int lane = bin % 4;
    const std::uint8_t certified = codes.code(block.certified[lane] * per_voxel);
    const std::uint8_t paper = codes.code(block.paper[lane] * per_voxel);
    const auto flips = static_cast<std::uint8_t>(block.flips[lane] | block.flips[4 + lane] << 4);
    const bool is_zero = (certified | paper | flips) == 0;
    if (first < 0 && is_zero) continue;
    if (first < 0) first = bin;
    if (!is_zero) end = bin + 1;
    codes_.insert(codes_.end(), {certified, paper, flips});
  }
  if (first < 0) return;
  codes_.resize(offset + 3 * static_cast<std::size_t>(end - first));
  entries_.push_back({.point = static_cast<std::uint16_t>(point),
                      .first = static_cast<std::uint16_t>(4 * curve.first + first),
                      .count = static_cast<std::uint16_t>(end - first),
                      .offset = offset});
}

std::vector<std::byte> SpectrumBrickBuilder::take() {
  std::vector<std::byte> bytes;
  if (entries_.empty()) return bytes;
  std::sort(entries_.begin(), entries_.end(),
            [](const Entry& a, const Entry& b) { return a.point < b.point; });
  std::size_t first = entries_.front().first;
  std::size_t end = 0;
  for (const Entry& entry : entries_) {
    first = std::min<std::size_t>(first, entry.first);
    end = std::max<std::size_t>(end, entry.first + std::size_t{entry.count});
  }
  append(bytes, static_cast<std::uint16_t>(first));
  append(bytes, static_cast<std::uint16_t>(end - first));
  bytes.resize(kHeadBytes + 4 * (end - first));
  const std::size_t planes = bytes.size();
  std::array<std::uint8_t, SpectrumLayout::kPoints> certified;
  std::array<std::uint8_t, SpectrumLayout::kPoints> paper;
  std::array<std::uint8_t, SpectrumLayout::kPoints> flips;
  for (std::size_t bin = first; bin < end; ++bin) {
    std::array<std::uint64_t, kMaskWords> mask{};
    std::size_t count = 0;
    for (const Entry& entry : entries_) {
      if (bin < entry.first || bin >= entry.first + std::size_t{entry.count}) continue;
      const std::uint8_t* const code = &codes_[entry.offset + 3 * (bin - entry.first)];
      if ((code[0] | code[1] | code[2]) == 0) continue;
      mask[entry.point / 64] |= std::uint64_t{1} << entry.point % 64;
      certified[count] = code[0];
      paper[count] = code[1];
      flips[count++] = code[2];
    }
    if (count > 0) {
      append(bytes, mask);
      for (const auto& codes : {&certified, &paper, &flips}) {
        const auto* const from = reinterpret_cast<const std::byte*>(codes->data());
        bytes.insert(bytes.end(), from, from + count);
      }
    }
    const auto plane_end = static_cast<std::uint32_t>(bytes.size() - planes);
    std::memcpy(&bytes[kHeadBytes + 4 * (bin - first)], &plane_end, sizeof(plane_end));
  }
  entries_.clear();
  codes_.clear();
  return bytes;
}

Result<SpectrumPlane> decode_plane(std::span<const std::byte> brick, int bin) {
  SpectrumPlane plane;
  if (brick.empty()) return plane;
  if (brick.size() < kHeadBytes) return damaged("ends within its header");
  const int first = number_at<std::uint16_t>(brick, 0);
  const int bins = number_at<std::uint16_t>(brick, 2);
  const std::size_t planes = kHeadBytes + 4 * static_cast<std::size_t>(bins);
  if (brick.size() < planes) return damaged("ends within its header");
  const int index = bin - first;
  if (index < 0 || index >= bins) return plane;
  const auto end_of = [&](int i) {
    return i < 0 ? 0
                 : number_at<std::uint32_t>(brick, kHeadBytes + 4 * static_cast<std::size_t>(i));
  };
  const std::size_t begin = end_of(index - 1);
  const std::size_t end = end_of(index);
  if (begin == end) return plane;
  if (begin > end || end > brick.size() - planes || end - begin < kMaskBytes) {
    return damaged("has a plane that extends beyond it");
  }
  const auto bytes = brick.subspan(planes + begin, end - begin);
  std::array<std::uint64_t, kMaskWords> mask;
  std::memcpy(mask.data(), bytes.data(), kMaskBytes);
  std::size_t count = 0;
  for (const std::uint64_t word : mask) count += static_cast<std::size_t>(std::popcount(word));
  if (bytes.size() != kMaskBytes + 3 * count) return damaged("has a plane of the wrong size");
  const auto* code = reinterpret_cast<const std::uint8_t*>(bytes.data() + kMaskBytes);
  for (std::size_t word = 0; word < kMaskWords; ++word) {
    for (std::uint64_t left = mask[word]; left != 0; left &= left - 1, ++code) {
      plane.points[64 * word + static_cast<std::size_t>(std::countr_zero(left))] = {
          .certified = code[0], .paper = code[count], .flips = code[2 * count]};
    }
  }
  return plane;
}

}  // namespace multitetra
