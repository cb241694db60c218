#include "server/dataset/objects/object_structure.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "server/core/spectrum/spectrum_layout.hpp"
#include "server/dataset/byte_source.hpp"
#include "server/dataset/checksum.hpp"

namespace multitetra {
namespace {

using namespace section_names;

Manifest manifest_at(const ObjectPlace& place) {
  const auto text = text_of(*place.store, kManifestName);
  if (!text) {
    throw DatasetFileError(place.place, std::string("there is no ") + kManifestName +
                                            " below it. Give the place of a dataset that `convert` "
                                            "made, and the credentials that it needs.");
  }
  auto manifest = parse_manifest(*text);
  if (!manifest) throw DatasetFileError(place.place, manifest.error().text);
  return *std::move(manifest);
}

// What a dataset's folder, or address, lies in.
std::string store_around(const std::string& place) {
  if (!is_address(place)) return (std::filesystem::path(place) / "..").string();
  std::string around = place;
  while (around.ends_with('/')) around.pop_back();
  const std::size_t slash = around.rfind('/');
  if (slash == std::string::npos || slash < around.find("://") + 3) {
    throw DatasetFileError(
        place,
        "its objects lie beside its folder, and the address names none. Give the "
        "address of a dataset in the store.");
  }
  return around.substr(0, slash);
}

// The names, which must be of objects with these sizes. Says what is wrong.
template <typename SizeOf>
Result<std::vector<ObjectName>> names_from(std::span<const std::byte> bytes,
                                           const SizeOf& size_of) {
  std::vector<ObjectName> names(bytes.size() / kNameBytes);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::byte* const at = bytes.data() + kNameBytes * i;
    std::memcpy(names[i].digest.data(), at, names[i].digest.size());
    std::memcpy(&names[i].size, at + names[i].digest.size(), sizeof(names[i].size));
    if (names[i].size == 0 || names[i].size > kMostObjectBytes || names[i].size != size_of(i)) {
      return fail(ErrorCode::kDamagedData, "object " + std::to_string(i) +
                                               " does not have the bytes that its bricks need. "
                                               "Convert the dataset again.");
    }
  }
  return names;
}

}  // namespace

std::vector<std::byte> bytes_of(std::span<const ObjectName> names) {
  std::vector<std::byte> bytes(kNameBytes * names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::byte* const at = bytes.data() + kNameBytes * i;
    std::memcpy(at, names[i].digest.data(), names[i].digest.size());
    std::memcpy(at + names[i].digest.size(), &names[i].size, sizeof(names[i].size));
  }
  return bytes;
}

ObjectReader::ObjectReader(ObjectPlace place, std::shared_ptr<ObjectCache> cache)
    : place_(std::move(place)), cache_(std::move(cache)), manifest_(manifest_at(place_)) {
  if (manifest_.shares_objects) place_.store = cache_->place(store_around(place_.place)).store;
  for (const char* const known : {kSamples, kSpectrum, kCoarse, kRanges, kBins, kSampleChecksums,
                                  kSpectrumIndex, kMetadata}) {
    if (find_section(manifest_.sections, known) == nullptr) {
      fail(std::string("the manifest has no section \"") + known +
           "\". Convert the dataset again.");
    }
  }
  for (const Section& section : manifest_.sections) {
    if (section.required && !is_known_section(section.name)) {
      fail("section \"" + section.name +
           "\" is required and this program does not know it. Use a newer one.");
    }
  }
}

void ObjectReader::fail(const std::string& what) const {
  throw DatasetFileError(place_.place, what);
}

std::vector<std::byte> ObjectReader::read(const ObjectRun& run, const RunPart& part) const {
  if (part.offset > run.bytes || part.size > run.bytes - part.offset) {
    fail("the manifest's runs are shorter than its sections. Convert the dataset again.");
  }
  std::vector<std::byte> bytes;  // Grows with what is there, not with what is promised.
  if (part.size == 0) return bytes;
  const auto first = static_cast<std::size_t>(part.offset / kRunObjectBytes);
  const auto last = static_cast<std::size_t>((part.offset + part.size - 1) / kRunObjectBytes);
  const auto names = std::span(run.objects).subspan(first, last - first + 1);
  if (names.size() > 1) cache_->will_need(place_, names);
  std::uint64_t skipped = part.offset % kRunObjectBytes;
  for (const ObjectName& name : names) {
    const ObjectBytes object = cache_->get(place_, name);
    const auto count = std::min<std::uint64_t>(part.size - bytes.size(), object->size() - skipped);
    const auto begin = object->begin() + static_cast<std::ptrdiff_t>(skipped);
    bytes.insert(bytes.end(), begin, begin + static_cast<std::ptrdiff_t>(count));
    skipped = 0;
  }
  return bytes;
}

void ObjectReader::check_sum(const char* name, std::span<const std::byte> bytes) const {
  const Section& section = *find_section(manifest_.sections, name);
  if (bytes.size() == section.size && checksum(bytes) == section.checksum) return;
  fail(std::string("section \"") + name +
       "\" does not have its checksum. Convert the dataset again.");
}

std::vector<std::byte> ObjectReader::section(const ObjectRun& run, const RunPart& part,
                                             const char* name) const {
  std::vector<std::byte> bytes = read(run, part);
  check_sum(name, bytes);
  return bytes;
}

ObjectStructure ObjectReader::structure() const {
  const auto size_of = [&](const char* name) {
    return find_section(manifest_.sections, name)->size;
  };
  const std::uint64_t known = size_of(kMetadata) + size_of(kBins) + size_of(kSpectrumIndex);
  if (known + size_of(kCoarse) > manifest_.first.bytes ||
      (manifest_.first.bytes - known - size_of(kCoarse)) % kNameBytes != 0 ||
      size_of(kMetadata) > (std::uint64_t{1} << 20)) {
    fail("the manifest's first run is not as long as its sections. Convert the dataset again.");
  }
  RunParts parts;
  std::uint64_t offset = 0;
  const auto next = [&offset](std::uint64_t size) {
    const RunPart part{.offset = offset, .size = size};
    offset += size;
    return part;
  };
  parts.metadata = next(size_of(kMetadata));
  parts.bins = next(size_of(kBins));
  parts.spectrum_index = next(size_of(kSpectrumIndex));
  parts.spectrum_names = next(manifest_.first.bytes - known - size_of(kCoarse));
  parts.coarse = next(size_of(kCoarse));

  const std::vector<std::byte> text = section(manifest_.first, parts.metadata, kMetadata);
  auto metadata = parse_metadata({reinterpret_cast<const char*>(text.data()), text.size()});
  if (!metadata) fail(metadata.error().text);
  const DatasetInfo& info = metadata->info;

  SampleObjects sample_objects(info.dims, info.type);
  offset = 0;
  parts.sample_names = next(kNameBytes * sample_objects.size());
  parts.sample_checksums = next(size_of(kSampleChecksums));
  parts.ranges = next(size_of(kRanges));
  for (const Section& other : manifest_.sections) {
    if (!is_known_section(other.name)) parts.others.emplace_back(other, next(other.size));
  }
  if (offset != manifest_.later.bytes ||
      size_of(kSampleChecksums) != sizeof(std::uint64_t) * sample_objects.bricks().size()) {
    fail("the manifest's later run is not as long as its sections. Convert the dataset again.");
  }

  auto index = decode_spectrum_index(section(manifest_.first, parts.spectrum_index, kSpectrumIndex),
                                     SpectrumLayout(info).size(), size_of(kSpectrum));
  if (!index) fail(index.error().text);
  SpectrumObjects spectrum_objects(info, *index);
  if (parts.spectrum_names.size != kNameBytes * spectrum_objects.size()) {
    fail(
        "the first run names more or fewer objects of the spectrum than there are. Convert the "
        "dataset again.");
  }
  auto names = names_from(read(manifest_.first, parts.spectrum_names), [&](std::size_t object) {
    const BrickInObject last = spectrum_objects.place(spectrum_objects.bricks_of(object).back());
    return std::uint64_t{last.offset} + last.size;
  });
  if (!names) fail(names.error().text);
  std::vector<std::byte> bins = section(manifest_.first, parts.bins, kBins);
  return {.manifest = manifest_,
          .parts = std::move(parts),
          .metadata = *std::move(metadata),
          .bins = std::move(bins),
          .spectrum_index = *std::move(index),
          .sample_objects = std::move(sample_objects),
          .spectrum_objects = std::move(spectrum_objects),
          .spectrum_names = *std::move(names)};
}

SampleIndex ObjectReader::sample_index(const ObjectStructure& structure) const {
  const auto& objects = structure.sample_objects;
  auto names = names_from(read(manifest_.later, structure.parts.sample_names),
                          [&](std::size_t object) { return objects.bytes_of(object); });
  if (!names) fail(names.error().text);
  const std::vector<std::byte> sums =
      section(manifest_.later, structure.parts.sample_checksums, kSampleChecksums);
  SampleIndex index{.names = *std::move(names),
                    .checksums = std::vector<std::uint64_t>(objects.bricks().size())};
  std::memcpy(index.checksums.data(), sums.data(), sums.size());
  return index;
}

std::set<ObjectName> ObjectReader::all_objects(const ObjectStructure& structure) const {
  const std::vector<ObjectName> samples = sample_index(structure).names;
  std::set<ObjectName> all(samples.begin(), samples.end());
  all.insert(structure.spectrum_names.begin(), structure.spectrum_names.end());
  all.insert(manifest_.first.objects.begin(), manifest_.first.objects.end());
  all.insert(manifest_.later.objects.begin(), manifest_.later.objects.end());
  return all;
}

}  // namespace multitetra
