// The "metadata" section of a prepared dataset, as JSON text.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/result.hpp"
#include "common/dataset/dataset_info.hpp"
#include "server/dataset/provenance.hpp"

namespace multitetra {

// The size of a label: its number of samples, and the volume inside its surface at error 0, in
// sample volumes. For samples at the end of the data, the half beyond it counts as inside.
struct LabelVolume {
  std::uint64_t samples = 0;
  double surface_samples = 0;
  std::optional<LabelExtent::Place> place = std::nullopt;  // Absent in files of earlier releases.

  [[nodiscard]] LabelExtent extent() const { return {.samples = samples, .place = place}; }
  friend bool operator==(const LabelVolume&, const LabelVolume&) = default;
};

struct DatasetMetadata {
  DatasetInfo info;
  // Present only for labels of known volume; info.label_extent is then its extent().
  std::optional<LabelVolume> label_volume = std::nullopt;
  Provenance source;
  // Version of the program that wrote the file.
  std::string program_version;

  friend bool operator==(const DatasetMetadata&, const DatasetMetadata&) = default;
};

// Returns equal text for equal metadata; numbers round-trip bit for bit. Bytes of the source note
// that are not UTF-8 become U+FFFD.
[[nodiscard]] std::string metadata_text(const DatasetMetadata& metadata);

// Ignores unknown fields. Returns kDamagedData, naming the field and the problem, unless every
// field is present and of its type and `check_info` accepts the whole.
[[nodiscard]] Result<DatasetMetadata> parse_metadata(std::string_view text);

}  // namespace multitetra
