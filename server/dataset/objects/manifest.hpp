// The manifest of a dataset that is made of objects: what there is, in one small JSON text.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.hpp"
#include "server/dataset/objects/object_name.hpp"
#include "server/dataset/section_table.hpp"

namespace multitetra {

inline constexpr std::uint32_t kObjectsVersion = 1;
// Of a manifest whose objects lie beside its folder; readers of version 1 know none.
inline constexpr std::uint32_t kSharedObjectsVersion = 2;
[[nodiscard]] bool is_large_section(std::string_view name);

inline constexpr const char* kManifestName = "manifest.json";

// Bytes that are longer than an object are cut after so many.
inline constexpr std::uint32_t kRunObjectBytes = std::uint32_t{4} << 20;

// Bytes that follow each other, in objects of kRunObjectBytes; the last one has what is left.
struct ObjectRun {
  std::uint64_t bytes = 0;
  std::vector<ObjectName> objects;

  friend bool operator==(const ObjectRun&, const ObjectRun&) = default;
};

// The sections are those of the single file, see ../README.md; what is in them is the same. The
// first run is what a first picture needs beside the spectrum:
//
//     metadata | bins | specidx | names of the spectrum's objects | coarse
//
// the later run what full resolution needs:
//
//     names of the samples' objects | smplsums | ranges | sections that this program does not know
//
// A name is 36 bytes: the digest, then the size, little-endian.
struct Manifest {
  std::string content_id;  // 16 hexadecimal digits, as of the single file.
  SectionTable sections;   // Of the single file, with their places in it. The two large ones have
                           // no checksum (0): their bricks have, and parts of them are made apart.
  ObjectRun first;
  ObjectRun later;
  // The objects lie beside the dataset's folder, together with those of other datasets there: in
  // ../objects, seen from the manifest. Else in objects.
  bool shares_objects = false;

  friend bool operator==(const Manifest&, const Manifest&) = default;
};

// What content_id must be.
[[nodiscard]] std::string content_id_text(const SectionTable& sections);

// The same text for the same manifest; its last field is the checksum of all others.
[[nodiscard]] std::string manifest_text(const Manifest& manifest);

// kDamagedData or kUnsupportedVersion, with what is wrong, unless it is whole and all places and
// sizes are possible.
[[nodiscard]] Result<Manifest> parse_manifest(std::string_view text);

}  // namespace multitetra
