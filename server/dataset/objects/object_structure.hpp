// What is known of a dataset made of objects before its bricks are read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "server/dataset/dataset_metadata.hpp"
#include "server/dataset/objects/manifest.hpp"
#include "server/dataset/objects/object_cache.hpp"
#include "server/dataset/objects/object_layout.hpp"
#include "server/dataset/prepared_format.hpp"

namespace multitetra {

// A part of a run.
struct RunPart {
  std::uint64_t offset = 0;
  std::uint64_t size = 0;
};

// Where the parts of both runs are (see manifest.hpp).
struct RunParts {
  RunPart metadata;
  RunPart bins;
  RunPart spectrum_index;
  RunPart spectrum_names;
  RunPart coarse;

  RunPart sample_names;
  RunPart sample_checksums;
  RunPart ranges;
  std::vector<std::pair<Section, RunPart>> others;
};

// From the first run.
struct ObjectStructure {
  Manifest manifest;
  RunParts parts;
  DatasetMetadata metadata;
  std::vector<std::byte> bins;
  std::vector<BrickPlace> spectrum_index;
  SampleObjects sample_objects;
  SpectrumObjects spectrum_objects;
  std::vector<ObjectName> spectrum_names;
};

// From the later run.
struct SampleIndex {
  std::vector<ObjectName> names;
  std::vector<std::uint64_t> checksums;  // Of the bricks.
};

// The bytes of names, one after the other, and back.
[[nodiscard]] std::vector<std::byte> bytes_of(std::span<const ObjectName> names);

inline constexpr std::uint64_t kNameBytes = 36;

// Reads a dataset's small parts. Functions throw StoreError when the store fails, and
// DatasetFileError, with the place and what to do, when something is damaged.
class ObjectReader {
 public:
  // Reads manifest.json. From then on place() has the store where the objects are.
  ObjectReader(ObjectPlace place, std::shared_ptr<ObjectCache> cache);

  [[nodiscard]] const ObjectPlace& place() const { return place_; }
  [[nodiscard]] ObjectCache& cache() const { return *cache_; }
  [[nodiscard]] const Manifest& manifest() const { return manifest_; }

  [[nodiscard]] ObjectStructure structure() const;
  [[nodiscard]] SampleIndex sample_index(const ObjectStructure& structure) const;
  // All objects of the dataset, each once.
  [[nodiscard]] std::set<ObjectName> all_objects(const ObjectStructure& structure) const;
  // The section "coarse" or "ranges", or one that is not known, with its checksum.
  [[nodiscard]] std::vector<std::byte> section(const ObjectRun& run, const RunPart& part,
                                               const char* name) const;

  [[noreturn]] void fail(const std::string& what) const;

 private:
  [[nodiscard]] std::vector<std::byte> read(const ObjectRun& run, const RunPart& part) const;
  void check_sum(const char* name, std::span<const std::byte> bytes) const;

  ObjectPlace place_;
  std::shared_ptr<ObjectCache> cache_;
  Manifest manifest_;
};

}  // namespace multitetra
