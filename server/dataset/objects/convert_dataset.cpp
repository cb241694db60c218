#include "server/dataset/objects/convert_dataset.hpp"

#include <algorithm>
#include <optional>
#include <set>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include "common/base/atomic_file.hpp"
#include "server/dataset/byte_source.hpp"
#include "server/dataset/checksum.hpp"
#include "server/dataset/objects/object_dataset.hpp"
#include "server/dataset/objects/object_folder.hpp"
#include "server/dataset/objects/object_structure.hpp"
#include "server/dataset/sample_facts.hpp"

namespace multitetra {
namespace {

using namespace section_names;

// Tells which part of the bytes is done.
class Share {
 public:
  Share(std::uint64_t total, const VerificationProgress& progress)
      : total_(std::max<std::uint64_t>(total, 1)), progress_(progress) {}
  void add(std::uint64_t bytes) {
    done_ += bytes;
    if (progress_) {
      progress_(std::min(1.0, static_cast<double>(done_) / static_cast<double>(total_)));
    }
  }

 private:
  std::uint64_t total_;
  std::uint64_t done_ = 0;
  const VerificationProgress& progress_;
};

// ---- from a file

class FileToObjects {
 public:
  FileToObjects(const std::filesystem::path& path, const std::filesystem::path& folder,
                bool shares_objects, const VerificationProgress& progress)
      : path_(path),
        file_(path),
        structure_(structure()),
        layout_(structure_.metadata.info.dims),
        shares_objects_(shares_objects),
        folder_(folder, shares_objects),
        share_(file_.size(), progress) {}

  ConvertedObjects convert(bool remove_others) {
    Manifest manifest{.content_id = content_id_text(structure_.sections),
                      .sections = structure_.sections,
                      .first = {},
                      .later = {},
                      .shares_objects = shares_objects_};
    const std::vector<ObjectName> spectrum = put_spectrum();
    const std::vector<ObjectName> samples = put_samples();
    RunWriter first(folder_);
    for (const char* const name : {kMetadata, kBins, kSpectrumIndex}) add_section(name, first);
    first.add(bytes_of(spectrum));
    add_section(kCoarse, first);
    manifest.first = first.finish();
    RunWriter later(folder_);
    later.add(bytes_of(samples));
    for (const char* const name : {kSampleChecksums, kRanges}) add_section(name, later);
    for (const Section& section : structure_.sections) {
      if (!is_known_section(section.name)) add_section(section.name.c_str(), later);
    }
    manifest.later = later.finish();
    for (Section& section : manifest.sections) {
      if (is_large_section(section.name)) section.checksum = 0;
    }
    folder_.finish(manifest);

    std::set<ObjectName> all(spectrum.begin(), spectrum.end());
    all.insert(samples.begin(), samples.end());
    all.insert(manifest.first.objects.begin(), manifest.first.objects.end());
    all.insert(manifest.later.objects.begin(), manifest.later.objects.end());
    ConvertedObjects converted{.objects = all.size()};
    for (const ObjectName& name : all) converted.bytes += name.size;
    converted.new_bytes = folder_.new_bytes();
    if (remove_others) {
      converted.removed_bytes = folder_.remove_others({all.begin(), all.end()});
    }
    return converted;
  }

 private:
  PreparedStructure structure() const {
    auto structure = decode_structure(file_);
    if (!structure) throw DatasetFileError(path_, structure.error().text);
    return *std::move(structure);
  }

  void add_brick(const char* section, std::size_t index, const BrickPlace& place,
                 std::optional<SampleType> type, std::vector<std::byte>& object) const {
    const std::size_t begin = object.size();
    object.resize(begin + place.size);
    const auto bytes = std::span(object).subspan(begin);
    file_.read(structure_.section(section).offset + place.offset, bytes);
    if (const auto whole = check_brick(section, index, bytes, place.checksum, type); !whole) {
      throw DatasetFileError(path_, whole.error().text);
    }
  }

  std::vector<ObjectName> put_samples() {
    const DatasetInfo& info = structure_.metadata.info;
    const SampleObjects objects(info.dims, info.type);
    std::vector<ObjectName> names;
    for (std::size_t i = 0; i < objects.size(); ++i) {
      std::vector<std::byte> object;
      for (const std::size_t brick : objects.bricks_of(i)) {
        add_brick(kSamples, brick, sample_brick_place(structure_, layout_, brick), info.type,
                  object);
      }
      names.push_back(folder_.put(object));
      share_.add(object.size());
    }
    return names;
  }

  std::vector<ObjectName> put_spectrum() {
    const SpectrumObjects objects(structure_.metadata.info, structure_.spectrum_index);
    std::vector<ObjectName> names;
    for (std::size_t i = 0; i < objects.size(); ++i) {
      std::vector<std::byte> object;
      for (const std::size_t brick : objects.bricks_of(i)) {
        add_brick(kSpectrum, brick, structure_.spectrum_index[brick], std::nullopt, object);
      }
      if (object.size() > kMostObjectBytes) {
        throw DatasetFileError(path_,
                               "Section \"spectrum\": a brick has more than 16 MiB. Prepare "
                               "the dataset again.");
      }
      names.push_back(folder_.put(object));
      share_.add(object.size());
    }
    return names;
  }

  void add_section(const char* name, RunWriter& run) {
    const Section& section = *find_section(structure_.sections, name);
    if (const auto checked = check_section(file_, section); !checked) {
      throw DatasetFileError(path_, checked.error().text);
    }
    std::vector<std::byte> portion;
    for (std::uint64_t done = 0; done < section.size; done += portion.size()) {
      portion.resize(std::min<std::uint64_t>(kRunObjectBytes, section.size - done));
      file_.read(section.offset + done, portion);
      run.add(portion);
      share_.add(portion.size());
    }
  }

  const std::filesystem::path& path_;
  const FileSource file_;
  const PreparedStructure structure_;
  const BrickLayout layout_;
  const bool shares_objects_;
  const ObjectFolder folder_;
  Share share_;
};

// ---- from objects

// Calls `visit(brick, place, bytes, section, type)` for all bricks, object by object; they have
// their checksums.
template <typename Visit>
void for_each_brick(const ObjectReader& reader, const ObjectStructure& structure,
                    const Visit& visit) {
  const auto whole = [&](const char* section, std::size_t brick, std::span<const std::byte> bytes,
                         std::uint64_t sum, std::optional<SampleType> type) {
    if (const auto checked = check_brick(section, brick, bytes, sum, type); !checked) {
      reader.fail(checked.error().text);
    }
    visit(section, brick, bytes);
  };
  const auto bytes_in = [](const ObjectBytes& object, const BrickInObject& at) {
    return std::span<const std::byte>(*object).subspan(at.offset, at.size);
  };
  const SampleIndex index = reader.sample_index(structure);
  const SampleObjects& samples = structure.sample_objects;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    reader.cache().will_need(
        reader.place(),
        std::span(index.names).subspan(i).first(std::min<std::size_t>(8, samples.size() - i)));
    const ObjectBytes object = reader.cache().get(reader.place(), index.names[i]);
    for (const std::size_t brick : samples.bricks_of(i)) {
      whole(kSamples, brick, bytes_in(object, samples.place(brick)), index.checksums[brick],
            structure.metadata.info.type);
    }
  }
  const SpectrumObjects& spectrum = structure.spectrum_objects;
  for (std::size_t i = 0; i < spectrum.size(); ++i) {
    const ObjectBytes object = reader.cache().get(reader.place(), structure.spectrum_names[i]);
    for (const std::size_t brick : spectrum.bricks_of(i)) {
      whole(kSpectrum, brick, bytes_in(object, spectrum.place(brick)),
            structure.spectrum_index[brick].checksum, std::nullopt);
    }
  }
}

// Calls `visit(section, bytes)` for all others.
template <typename Visit>
void for_each_small_section(const ObjectReader& reader, const ObjectStructure& structure,
                            const Visit& visit) {
  const RunParts& parts = structure.parts;
  const auto one = [&](const ObjectRun& run, const RunPart& part, const char* name) {
    visit(*find_section(structure.manifest.sections, name), reader.section(run, part, name));
  };
  one(structure.manifest.first, parts.metadata, kMetadata);
  one(structure.manifest.first, parts.bins, kBins);
  one(structure.manifest.first, parts.spectrum_index, kSpectrumIndex);
  one(structure.manifest.first, parts.coarse, kCoarse);
  one(structure.manifest.later, parts.sample_checksums, kSampleChecksums);
  one(structure.manifest.later, parts.ranges, kRanges);
  for (const auto& [section, part] : parts.others) {
    one(structure.manifest.later, part, section.name.c_str());
  }
}

std::uint64_t file_bytes(const SectionTable& sections) {
  return sections.back().offset + sections.back().size;
}

// The file that is being written.
class UnfinishedFile : public ByteSource {
 public:
  UnfinishedFile(const AtomicFile& file, std::uint64_t size) : file_(file), size_(size) {}
  [[nodiscard]] std::uint64_t size() const override { return size_; }
  void read(std::uint64_t offset, std::span<std::byte> into) const override {
    file_.read_at(offset, into);
  }

 private:
  const AtomicFile& file_;
  std::uint64_t size_;
};

std::uint64_t checksum_of(const ByteSource& source, const Section& section) {
  RunningChecksum sum;
  std::vector<std::byte> portion;
  for (std::uint64_t done = 0; done < section.size; done += portion.size()) {
    portion.resize(std::min<std::uint64_t>(kRunObjectBytes, section.size - done));
    source.read(section.offset + done, portion);
    sum.add(portion);
  }
  return sum.value();
}

}  // namespace

ConvertedObjects file_to_objects(const std::filesystem::path& file,
                                 const std::filesystem::path& folder, bool remove_others,
                                 const VerificationProgress& progress) {
  return FileToObjects(file, folder, /*shares_objects=*/false, progress).convert(remove_others);
}

ConvertedObjects file_to_shared_objects(const std::filesystem::path& file,
                                        const std::filesystem::path& folder,
                                        const VerificationProgress& progress) {
  return FileToObjects(file, folder, /*shares_objects=*/true, progress)
      .convert(/*remove_others=*/false);
}

std::uint64_t remove_unused_objects(const std::filesystem::path& store) {
  const auto cache = std::make_shared<ObjectCache>();
  std::set<ObjectName> used;
  try {
    for (const auto& entry : std::filesystem::directory_iterator(store)) {
      const std::string place = entry.path().string();
      if (!is_object_dataset(place)) continue;
      const ObjectReader reader(cache->place(place), cache);
      if (reader.manifest().shares_objects) used.merge(reader.all_objects(reader.structure()));
    }
  } catch (const std::filesystem::filesystem_error& error) {
    throw DatasetFileError(store, std::string(error.what()) + ".");
  }
  return ObjectFolder(store).remove_others({used.begin(), used.end()});
}

void objects_to_file(const std::string& place, const std::shared_ptr<ObjectCache>& cache,
                     const std::filesystem::path& path, const VerificationProgress& progress) {
  const ObjectReader reader(cache->place(place), cache);
  const ObjectStructure structure = reader.structure();
  const SectionTable& sections = structure.manifest.sections;
  try {
    AtomicFile file(path);
    Share share(file_bytes(sections), progress);
    for_each_brick(reader, structure,
                   [&](const char* section, std::size_t brick, std::span<const std::byte> bytes) {
                     const auto width =
                         static_cast<std::uint64_t>(bytes_per_sample(structure.metadata.info.type));
                     const BrickLayout& layout = structure.sample_objects.bricks();
                     const std::uint64_t offset = std::string_view(section) == kSamples
                                                      ? width * layout.offset(layout.at(brick))
                                                      : structure.spectrum_index[brick].offset;
                     file.write_at(find_section(sections, section)->offset + offset, bytes);
                     share.add(bytes.size());
                   });
    for_each_small_section(reader, structure,
                           [&](const Section& section, std::span<const std::byte> bytes) {
                             file.write_at(section.offset, bytes);
                           });
    const UnfinishedFile written(file, file_bytes(sections));
    SectionTable table = sections;
    for (Section& section : table) {
      if (is_large_section(section.name)) section.checksum = checksum_of(written, section);
    }
    const std::string head = encode_head(table);
    file.write_at(0, std::as_bytes(std::span(head)));
    const auto verified = verify_bytes(written);
    if (!verified) reader.fail(verified.error().text);
    file.commit(Durability::kMachineStop);
  } catch (const std::system_error& error) {
    throw DatasetFileError(std::string(error.what()) + ".");
  }
}

VerifiedObjects verify_objects(const std::string& place, const std::shared_ptr<ObjectCache>& cache,
                               const VerificationProgress& progress) {
  const ObjectReader reader(cache->place(place), cache);
  const ObjectStructure structure = reader.structure();
  const DatasetInfo& info = structure.metadata.info;
  if (structure.manifest.content_id != content_id_text(structure.manifest.sections)) {
    reader.fail(
        "the manifest's content_id is not that of its sections. Convert the dataset again.");
  }
  Share share(file_bytes(structure.manifest.sections), progress);
  SampleFacts facts;
  for_each_brick(reader, structure,
                 [&](const char* section, std::size_t, std::span<const std::byte> bytes) {
                   if (std::string_view(section) == kSamples) facts.add(info.type, bytes);
                   share.add(bytes.size());
                 });
  if (const auto checked = check_facts(info, facts); !checked) reader.fail(checked.error().text);
  for_each_small_section(reader, structure, [&](const Section&, std::span<const std::byte> bytes) {
    share.add(bytes.size());
  });
  if (progress) progress(1);
  const std::set<ObjectName> all = reader.all_objects(structure);
  VerifiedObjects verified{.objects = all.size()};
  for (const ObjectName& name : all) verified.bytes += name.size;
  return verified;
}

}  // namespace multitetra
