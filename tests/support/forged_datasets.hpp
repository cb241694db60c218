// Prepared datasets with changes that a checksum does not reveal.
#pragma once

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "server/dataset/brick_codec.hpp"
#include "server/dataset/detail/packed_bytes.hpp"
#include "tests/fuzz/dataset_file_input.hpp"

namespace multitetra::testing {

// Changes a valid file, from a seed: one or a few of its sections, with all checksums corrected.
class DatasetForger {
 public:
  DatasetForger(std::string_view file, std::uint32_t seed) : random_(seed) {
    const auto table = decode_section_table(MemorySource(std::as_bytes(std::span(file))));
    for (std::size_t i = 0; i < sections_.size(); ++i) {
      const Section& section = *find_section(*table, kFuzzedSections[i]);
      sections_[i] = file.substr(section.offset, section.size);
    }
  }

  [[nodiscard]] std::string forged() {
    for (int changes = 1 + any(3); changes > 0; --changes) change_section();
    return file();
  }

  // Replaces a packed brick of samples by these bytes.
  void replace_sample_brick(std::size_t brick, BrickCodec codec, std::string_view bytes) {
    replace_brick(sections_[kSamples], sections_[kSampleIndex], brick, codec, bytes);
  }
  // Returns the file as it is now.
  [[nodiscard]] std::string file() const {
    std::string input = "s";
    for (const std::string& section : sections_) {
      const auto size = static_cast<std::uint16_t>(section.size());
      input.append(reinterpret_cast<const char*>(&size), sizeof(size));
      input.append(section, 0, size);
    }
    return dataset_file_of(input);
  }

 private:
  enum Index {
    kMetadata,
    kBins,
    kSpectrumIndex,
    kCoarse,
    kSpectrum,
    kRanges,
    kSamples,
    kSampleIndex
  };

  [[nodiscard]] int any(int end) { return std::uniform_int_distribution<int>(0, end - 1)(random_); }

  void change_section() {
    switch (any(7)) {
      case 0:
        return change_metadata();
      case 1:
        return change_numbers(sections_[kBins], sizeof(float));
      case 2:
        return change_packed(sections_[kCoarse]);
      case 3:
        return change_packed(sections_[kRanges]);
      case 4:
        return change_brick(sections_[kSpectrum], sections_[kSpectrumIndex]);
      case 5:
        return change_brick(sections_[kSamples], sections_[kSampleIndex]);
      default:
        return change_bytes(sections_[static_cast<std::size_t>(any(8))]);
    }
  }

  void change_bytes(std::string& bytes) {
    if (bytes.empty()) return;
    for (int count = 1 + any(4); count > 0; --count) {
      bytes[static_cast<std::size_t>(any(static_cast<int>(bytes.size())))] =
          static_cast<char>(any(256));
    }
  }

  void change_metadata() {
    nlohmann::json json = nlohmann::json::parse(sections_[kMetadata], nullptr, false);
    if (json.is_discarded()) return;
    nlohmann::json* at = &json;
    while (at->is_structured() && !at->empty()) {
      auto next = at->begin();
      std::advance(next, any(static_cast<int>(at->size())));
      at = &*next;
      if (any(8) == 0) break;
    }
    static const std::array<nlohmann::json, 16> kValues = {
        0,   1,      -1,    2,          15,          16,      17, 255,
        0.5, 1e-300, 1e300, 2147483647, 4294967295U, nullptr, "", nlohmann::json::array()};
    *at = kValues[static_cast<std::size_t>(any(kValues.size()))];
    sections_[kMetadata] = json.dump();
  }

  // Sets some of the numbers to extreme or random values.
  void change_numbers(std::string& bytes, std::size_t item) {
    if (bytes.size() < item) return;
    for (int count = 1 + any(4); count > 0; --count) {
      const auto at = item * static_cast<std::size_t>(any(static_cast<int>(bytes.size() / item)));
      static constexpr std::array<float, 6> kFloats = {0,
                                                       std::numeric_limits<float>::quiet_NaN(),
                                                       std::numeric_limits<float>::infinity(),
                                                       -std::numeric_limits<float>::infinity(),
                                                       1e38F,
                                                       1e-38F};
      const auto number = std::bit_cast<std::uint32_t>(kFloats[static_cast<std::size_t>(any(6))]);
      const std::uint32_t value = any(2) == 0 ? number : static_cast<std::uint32_t>(random_());
      std::memcpy(bytes.data() + at, &value, std::min(item, sizeof(value)));
    }
  }

  // Changes a section of packed pieces, after unpacking.
  void change_packed(std::string& section) {
    std::string whole;
    for (std::size_t at = 0; at + 4 <= section.size();) {
      std::uint32_t head = 0;
      std::memcpy(&head, section.data() + at, sizeof(head));
      const BrickPlace place{.size_and_codec = head};
      if (place.size() > section.size() - at - 4) return;
      const auto packed = std::as_bytes(std::span(section)).subspan(at + 4, place.size());
      std::string piece(unpacked_size(place.codec(), packed).value_or(0), 0);
      if (!unpack_brick(place.codec(), packed, std::as_writable_bytes(std::span(piece)))) return;
      whole += piece;
      at += 4 + place.size();
    }
    change_numbers(whole, sizeof(float));
    if (whole.empty() || whole.size() > kPieceBytes) return;
    const std::uint32_t head = size_with_codec(whole.size(), BrickCodec::kRaw);
    section.assign(reinterpret_cast<const char*>(&head), sizeof(head));
    section += whole;
  }

  void change_brick(std::string& bricks, std::string& index) {
    const std::size_t count = index.size() / sizeof(BrickEntry);
    if (count == 0) return;
    const auto brick = static_cast<std::size_t>(any(static_cast<int>(count)));
    const BrickPlace place = place_of(index, brick);
    if (!is_whole(index, bricks)) return;  // After an earlier change of the index.
    const auto packed = std::as_bytes(std::span(bricks)).subspan(place.offset, place.size());
    std::string bytes(unpacked_size(place.codec(), packed).value_or(0), 0);
    (void)unpack_brick(place.codec(), packed, std::as_writable_bytes(std::span(bytes)));
    switch (any(6)) {
      case 0:
        bytes.clear();
        break;
      case 1:
        bytes.resize(static_cast<std::size_t>(any(64)));
        break;
      case 2:
        bytes.append(static_cast<std::size_t>(1 + any(64)), 0x55);
        break;
      case 3:
        change_bytes(bytes);
        break;
      default:
        change_numbers(bytes, sizeof(float));
    }
    replace_brick(bricks, index, brick, any(8) == 0 ? BrickCodec::kConstant : BrickCodec::kRaw,
                  bytes);
  }

  // Returns the place of the brick with this number in the order of the file.
  [[nodiscard]] static BrickPlace place_of(const std::string& index, std::size_t brick) {
    std::uint64_t end = 0;
    for (std::size_t i = 0;; ++i) {
      BrickEntry entry;
      std::memcpy(&entry, index.data() + i * sizeof(entry), sizeof(entry));
      const BrickPlace place{.offset = brick_begin(end), .size_and_codec = entry.size_and_codec};
      if (i == brick) return place;
      end = place.offset + place.size();
    }
  }

  // Returns whether the bricks fill their section.
  [[nodiscard]] static bool is_whole(const std::string& index, const std::string& bricks) {
    const BrickPlace last = place_of(index, index.size() / sizeof(BrickEntry) - 1);
    return last.offset + last.size() == bricks.size();
  }

  static void replace_brick(std::string& bricks, std::string& index, std::size_t brick,
                            BrickCodec codec, std::string_view bytes) {
    std::string made;
    for (std::size_t i = 0; i < index.size() / sizeof(BrickEntry); ++i) {
      const BrickPlace place = place_of(index, i);
      const std::string_view old = std::string_view(bricks).substr(place.offset, place.size());
      made.resize(brick_begin(made.size()));
      made += i == brick ? bytes : old;
    }
    BrickEntry entry{.size_and_codec = size_with_codec(bytes.size(), codec)};
    std::memcpy(index.data() + brick * sizeof(entry), &entry, sizeof(entry));
    bricks = made;
  }

  std::mt19937 random_;
  std::array<std::string, kFuzzedSections.size()> sections_;
};

}  // namespace multitetra::testing
