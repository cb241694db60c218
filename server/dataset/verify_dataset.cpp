#include "server/dataset/verify_dataset.hpp"

#include <algorithm>
#include <cstdint>
#include <new>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "server/dataset/checksum.hpp"
#include "server/dataset/prepared_format.hpp"
#include "server/dataset/sample_facts.hpp"

namespace multitetra {
namespace {

using namespace section_names;

// Tells about each further percent.
class Ticker {
 public:
  Ticker(std::uint64_t total, const VerificationProgress& progress)
      : total_(total), progress_(progress) {}
  void add(std::uint64_t bytes) {
    done_ += bytes;
    const std::uint64_t percent = done_ * 100 / total_;
    if (!progress_ || percent <= told_percent_) return;
    told_percent_ = percent;
    progress_(static_cast<double>(percent) / 100);
  }

 private:
  std::uint64_t total_;
  std::uint64_t done_ = 0;
  std::uint64_t told_percent_ = 0;
  const VerificationProgress& progress_;
};

// A brick's own checksum comes first, since it says where the damage is.
class LargeSection {
 public:
  LargeSection(const ByteSource& source, const Section& section, std::optional<SampleType> type,
               Ticker& ticker)
      : source_(source), section_(section), type_(type), ticker_(ticker) {}

  // The next brick in the order of the file. Returns what is wrong with it.
  Result<void> add(std::size_t index, const BrickPlace& place) {
    brick_.resize(place.size);
    source_.read(section_.offset + place.offset, brick_);
    if (auto checked = check_brick(section_.name, index, brick_, place.checksum, type_); !checked) {
      return checked;
    }
    checksum_.add(brick_);
    ticker_.add(brick_.size());
    return {};
  }
  // Of the brick that was added last.
  [[nodiscard]] std::span<const std::byte> brick() const { return brick_; }

  // When all bricks were added: what is wrong with the section.
  [[nodiscard]] Result<void> whole() const {
    if (checksum_.value() == section_.checksum) return {};
    return damaged(section_.name, "its checksum does not match.");
  }

 private:
  const ByteSource& source_;
  const Section& section_;
  std::optional<SampleType> type_;
  Ticker& ticker_;
  RunningChecksum checksum_;
  std::vector<std::byte> brick_;
};

Result<void> verify_samples(const ByteSource& source, const PreparedStructure& structure,
                            Ticker& ticker) {
  const DatasetInfo& info = structure.metadata.info;
  const BrickLayout layout(info.dims);
  LargeSection samples(source, structure.section(kSamples), info.type, ticker);
  SampleFacts facts;
  for (std::size_t i = 0; i < layout.size(); ++i) {
    if (auto checked = samples.add(i, sample_brick_place(structure, layout, i)); !checked)
      return checked;
    facts.add(info.type, samples.brick());
  }
  if (auto checked = samples.whole(); !checked) return checked;
  return check_facts(info, facts);
}

Result<void> verify_spectrum(const ByteSource& source, const PreparedStructure& structure,
                             Ticker& ticker) {
  const Section& section = structure.section(kSpectrum);
  LargeSection spectrum(source, section, std::nullopt, ticker);
  const auto order = bricks_in_file_order(structure.spectrum_index, section.size);
  for (const std::size_t i : order.value()) {  // decode_structure made sure that there is one.
    if (auto checked = spectrum.add(i, structure.spectrum_index[i]); !checked) return checked;
  }
  return spectrum.whole();
}

}  // namespace

Result<void> verify_bytes(const ByteSource& source, const VerificationProgress& progress) {
  Ticker ticker(std::max<std::uint64_t>(source.size(), 1), progress);
  const auto structure = decode_structure(source);
  if (!structure) return tl::unexpected(structure.error());
  if (auto checked = verify_samples(source, *structure, ticker); !checked) return checked;
  if (auto checked = verify_spectrum(source, *structure, ticker); !checked) return checked;
  // The small ones are verified already; there may be others, of later versions.
  for (const Section& section : structure->sections) {
    if (is_known_section(section.name)) continue;
    if (auto checked = check_section(source, section); !checked) return checked;
    ticker.add(section.size);
  }
  if (progress) progress(1);
  return {};
}

void verify_dataset(const std::filesystem::path& path, const VerificationProgress& progress) {
  try {
    const auto verified = verify_bytes(FileSource(path), progress);
    if (!verified) throw DatasetFileError(path, verified.error().text);
  } catch (const std::bad_alloc&) {
    throw DatasetFileError(path, "there is not enough memory for its index.");
  }
}

}  // namespace multitetra
