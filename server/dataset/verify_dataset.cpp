#include "server/dataset/verify_dataset.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "common/base/number_text.hpp"
#include "common/base/result.hpp"
#include "common/dataset/dataset_info.hpp"
#include "common/mesh/checksum.hpp"
#include "server/dataset/brick_order.hpp"
#include "server/dataset/prepared_format.hpp"

namespace multitetra {
namespace {

// The metadata that are computed from the samples.
struct SampleFacts {
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();
  std::uint64_t void_samples = 0;

  void add(SampleType type, std::span<const std::byte> bytes) {
    visit_type(type, [&]<typename Sample>(const Sample*) {
      for (; bytes.size() >= sizeof(Sample); bytes = bytes.subspan(sizeof(Sample))) {
        Sample sample{};
        std::memcpy(&sample, bytes.data(), sizeof(Sample));
        const auto value = static_cast<double>(sample);
        if (std::isnan(value)) {
          ++void_samples;
          continue;
        }
        min = std::min(min, value);
        max = std::max(max, value);
      }
    });
  }
};

// Returns kDamagedData if `facts` differ from the metadata.
Result<void> check_facts(const DatasetInfo& info, SampleFacts facts) {
  if (facts.min > facts.max) facts.min = facts.max = 0;  // All samples are void.
  if (facts.min == info.min && facts.max == info.max && facts.void_samples == info.void_samples) {
    return {};
  }
  return damaged(section_names::kMetadata,
                 "the metadata declare samples from " + shortest_text(info.min) + " to " +
                     shortest_text(info.max) + " and " + std::to_string(info.void_samples) +
                     " void samples; the samples range from " + shortest_text(facts.min) + " to " +
                     shortest_text(facts.max) + " and " + std::to_string(facts.void_samples) +
                     " are void.");
}

using namespace section_names;

// Reports progress at each percent.
class Ticker {
 public:
  Ticker(std::uint64_t total, const VerificationProgress& progress)
      : total_(total), progress_(progress) {}
  void add(std::uint64_t bytes) {
    done_ += bytes;
    const std::uint64_t percent = done_ * 100 / total_;
    if (!progress_ || percent <= reported_percent_) return;
    reported_percent_ = percent;
    progress_(static_cast<double>(percent) / 100);
  }

 private:
  std::uint64_t total_;
  std::uint64_t done_ = 0;
  std::uint64_t reported_percent_ = 0;
  const VerificationProgress& progress_;
};

// Calls visit(bytes) with each unpacked brick of a section, in the order of the file. Checks a
// brick's own checksum before that of the section, since it locates the damage. `type` is absent
// for the spectrum.
template <typename Layout, typename Visit>
Result<void> verify_bricks(const ByteSource& source, const Section& section, const Layout& layout,
                           std::span<const BrickPlace> places, std::optional<SampleType> type,
                           const Visit& visit, Ticker& ticker) {
  Result<void> checked;
  RunningChecksum sum;
  std::uint64_t end = 0;
  std::vector<std::byte> packed;
  std::vector<std::byte> unpacked;
  in_file_order(layout, [&](std::size_t brick) {
    if (!checked) return;
    const BrickPlace& place = places[brick];
    // Includes the padding before the brick.
    packed.resize(static_cast<std::size_t>(place.offset + place.size() - end));
    source.read(section.offset + end, packed);
    sum.add(packed);
    end += packed.size();
    ticker.add(packed.size());
    if (place.size() == 0) return;
    std::size_t bytes = 0;
    if constexpr (std::is_same_v<Layout, BrickLayout>) {
      bytes = layout.volume(layout.at(brick)) * static_cast<std::size_t>(bytes_per_sample(*type));
    }
    checked = unpack_checked(section.name, brick, place, std::span(packed).last(place.size()), type,
                             bytes, unpacked);
    if (checked) visit(unpacked);
  });
  if (checked && sum.value() != section.checksum) {
    return damaged(section.name, "its checksum does not match.");
  }
  return checked;
}

Result<void> verify_samples(const ByteSource& source, const PreparedStructure& structure,
                            Ticker& ticker) {
  const DatasetInfo& info = structure.metadata.info;
  const auto index = decode_sample_index(source, structure);
  if (!index) return tl::unexpected(index.error());
  SampleFacts facts;
  if (auto checked = verify_bricks(
          source, structure.section(kSamples), BrickLayout(info.dims), *index, info.type,
          [&](std::span<const std::byte> brick) { facts.add(info.type, brick); }, ticker);
      !checked) {
    return checked;
  }
  return check_facts(info, facts);
}

Result<void> verify_small_sections(const ByteSource& source, const PreparedStructure& structure) {
  const DatasetInfo& info = structure.metadata.info;
  if (auto checked = check_padding(source, structure.sections); !checked) return checked;
  if (const auto coarse =
          read_packed_section(source, structure.section(kCoarse), coarse_bytes(info));
      !coarse) {
    return tl::unexpected(coarse.error());
  }
  const auto ranges = read_packed_section(source, structure.section(kRanges), ranges_bytes(info));
  return ranges ? Result<void>() : tl::unexpected(ranges.error());
}

}  // namespace

Result<void> verify_bytes(const ByteSource& source, const VerificationProgress& progress) {
  Ticker ticker(std::max<std::uint64_t>(source.size(), 1), progress);
  const auto structure = decode_structure(source);
  if (!structure) return tl::unexpected(structure.error());
  if (auto checked = verify_small_sections(source, *structure); !checked) return checked;
  if (structure->has_errors()) {
    if (auto checked = verify_bricks(
            source, structure->section(kSpectrum), SpectrumLayout(structure->metadata.info),
            structure->spectrum_index, std::nullopt, [](std::span<const std::byte>) {}, ticker);
        !checked) {
      return checked;
    }
  }
  if (auto checked = verify_samples(source, *structure, ticker); !checked) return checked;
  // Files of later versions may have more sections.
  for (const Section& section : structure->sections) {
    if (is_known_section(section.name)) continue;
    if (auto checked = check_section(source, section); !checked) return checked;
    ticker.add(section.size);
  }
  if (progress) progress(1);
  return {};
}

std::uint64_t verify_dataset(const std::string& place, const VerificationProgress& progress) {
  try {
    std::unique_ptr<const ByteSource> source;
    if (is_address(place)) {
      source = std::make_unique<RemoteSource>(std::make_shared<RemoteFiles>()->open(place));
    } else {
      source = std::make_unique<FileSource>(place);
    }
    const auto verified = verify_bytes(*source, progress);
    if (!verified) throw DatasetFileError(place, verified.error().text);
    return source->size();
  } catch (const std::bad_alloc&) {
    throw DatasetFileError(place, "there is not enough memory for its index.");
  }
}

}  // namespace multitetra
