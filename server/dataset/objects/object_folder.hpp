// A folder that takes the objects of a dataset, and its manifest last.
//
//   ObjectFolder folder("head");
//   names.push_back(folder.put(bytes));
//   folder.finish(manifest);
//
// Guaranteed: objects appear whole or not at all, and one that is there already is not written
// again; the manifest replaces the one before at once, when all that it names is on the disk. So
// whoever has the version before open goes on with it: its objects stay until remove_others().
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "server/dataset/objects/manifest.hpp"
#include "server/dataset/objects/object_name.hpp"

namespace multitetra {

// Functions throw DatasetFileError when the disk fails. Several threads or processes may put.
class ObjectFolder {
 public:
  // Makes the folder where there is none. The objects lie in it, or, with `shares_objects`, in the
  // folder that it is in, where other datasets have theirs.
  explicit ObjectFolder(const std::filesystem::path& folder, bool shares_objects = false);

  // Requires 1 to kMostObjectBytes bytes.
  ObjectName put(std::span<const std::byte> bytes) const;
  // The bytes of objects that were put and not there before.
  [[nodiscard]] std::uint64_t new_bytes() const { return new_bytes_; }
  // Requires a manifest that shares its objects as the folder does.
  void finish(const Manifest& manifest) const;

  // Removes the objects that are none of these. Returns how many bytes they had.
  std::uint64_t remove_others(std::vector<ObjectName> used) const;

 private:
  std::filesystem::path folder_;
  std::filesystem::path objects_;  // What keys of objects are below.
  bool shares_objects_;
  mutable std::atomic<std::uint64_t> new_bytes_ = 0;
};

// Bytes that come in pieces, cut into the objects of a run.
class RunWriter {
 public:
  explicit RunWriter(const ObjectFolder& folder) : folder_(folder) {}
  void add(std::span<const std::byte> bytes);
  // When all were added.
  [[nodiscard]] ObjectRun finish();

 private:
  const ObjectFolder& folder_;
  ObjectRun run_;
  std::vector<std::byte> buffer_;
};

}  // namespace multitetra
