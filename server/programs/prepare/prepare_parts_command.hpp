// `prepare` on several machines: --plan, --part and --merge.
#pragma once

#include <cstddef>
#include <string>

#include "server/dataset/prepare.hpp"
#include "server/dataset/provenance.hpp"
#include "server/volume/volume_source.hpp"

namespace multitetra {

struct PartsArguments {
  // The number of parts to plan; 0: none.
  int plan = 0;
  // The part to prepare, such as "3/8"; empty: none.
  std::string part;
  bool merge = false;

  [[nodiscard]] bool are_given() const { return plan > 0 || !part.empty() || merge; }
};

struct PartNumber {
  std::size_t index = 0;  // From 0.
  std::size_t parts = 1;
};

// Parses a part such as "3/8". Throws ExitError unless it is from 1 to 8 of at most kMaxParts.
[[nodiscard]] PartNumber part_of(const std::string& text);

struct PartsReport {
  bool json = false;
  bool quiet = false;
};

// Reads the volume, writes the plan, and prints one line per part with its command and expected
// cost.
int plan_parts(VolumeSource& source, const PrepareOptions& options, Provenance note,
               const std::string& input, const std::string& output, std::size_t parts,
               const PartsReport& report);

// Prepares one part, such as "3/8". Throws ExitError if the plan does not have it.
int make_part(VolumeSource& source, const std::string& output, const std::string& part,
              const PartsReport& report);

// Merges the parts into the dataset. Throws DatasetFileError, with their numbers, if parts are
// missing.
int merge(const std::string& output, const PartsReport& report);

}  // namespace multitetra
