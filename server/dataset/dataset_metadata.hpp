// The section "metadata" of a prepared dataset: what is known of it, as JSON text.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/result.hpp"
#include "common/request/dataset_info.hpp"
#include "server/dataset/provenance.hpp"

namespace multitetra {

// The volume inside a label's surface at error 0, beside its samples, in volumes of a sample. Of
// samples where the data end, the half beyond counts as held.
struct LabelVolume {
  std::uint64_t samples = 0;
  double surface_samples = 0;
  std::optional<LabelExtent::Place> place = std::nullopt;  // None: prepared by an earlier release.

  [[nodiscard]] LabelExtent extent() const { return {.samples = samples, .place = place}; }
  friend bool operator==(const LabelVolume&, const LabelVolume&) = default;
};

struct DatasetMetadata {
  DatasetInfo info;
  // None: not a label's, or not known. Else info.label_extent is its extent().
  std::optional<LabelVolume> label_volume = std::nullopt;
  Provenance source;
  // The version of the program that wrote the file.
  std::string program_version;

  friend bool operator==(const DatasetMetadata&, const DatasetMetadata&) = default;
};

// The same text for the same metadata; numbers come back bit for bit. Bytes of the source note that
// are not UTF-8 become U+FFFD.
[[nodiscard]] std::string metadata_text(const DatasetMetadata& metadata);

// kDamagedData, with the field and what is wrong, unless every field is there, of its type, and the
// whole passes `check_info`. Fields it does not know are left out.
[[nodiscard]] Result<DatasetMetadata> parse_metadata(std::string_view text);

}  // namespace multitetra
