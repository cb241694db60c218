#include "server/dataset/prepared_file.hpp"

#include <filesystem>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/dataset/byte_source.hpp"
#include "server/dataset/detail/mapped_file.hpp"
#include "server/dataset/provenance.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kOwnCacheBytes = std::size_t{256} << 20;

// Throws if `read` fails. If memory for an index runs out, reports the file as damaged.
template <typename Read>
auto value_or_throw(const std::string& place, const Read& read) {
  try {
    auto found = read();
    if (!found) throw DatasetFileError(place, found.error().text);
    return *std::move(found);
  } catch (const std::bad_alloc&) {
    throw DatasetFileError(place, "there is not enough memory for its index.");
  }
}

std::string advice_for_another_file(const std::string& place) {
  const std::string text = place + " is not a prepared dataset.";
  if (std::filesystem::path(place).extension() == ".mtd") return text;
  return text + " Prepare it first: multitetra-server prepare " + place + " -o " +
         default_dataset_name(place) + ".mtd";
}

BrickFile with_structure(BrickFile file) {
  const std::string& place = file.place;
  file.structure = std::make_shared<const PreparedStructure>(value_or_throw(place, [&] {
    auto structure = decode_structure(*file.source);
    if (!structure && structure.error().code == ErrorCode::kInvalidArgument) {
      throw DatasetFileError(advice_for_another_file(place));
    }
    return structure;
  }));
  return file;
}

BrickFile open_file(const std::string& place, std::shared_ptr<RemoteFiles> files) {
  if (!files) {
    files = std::make_shared<RemoteFiles>(RemoteFilesOptions{.memory_bytes = kOwnCacheBytes});
  }
  BrickFile file{.place = place, .cache = std::shared_ptr<MemoryCache>(files, &files->memory())};
  if (is_address(place)) {
    file.source = std::make_shared<const RemoteSource>(files->open(place));
  } else {
    file.source = std::make_shared<const MappedFile>(place);
  }
  return with_structure(std::move(file));
}

}  // namespace

struct PreparedFile::Content {
  // A packed section, unpacked on first use.
  struct SmallSection {
    SmallSection() = default;
    mutable std::once_flag is_read;
    mutable std::vector<std::byte> bytes;
  };

  explicit Content(BrickFile opened) : file(std::move(opened)), samples(file) {
    if (file.structure->has_errors()) spectrum.emplace(file);
    if (!file.source->is_remote()) (void)samples.index();
  }

  [[nodiscard]] std::span<const std::byte> unpacked(const SmallSection& section, const char* name,
                                                    std::uint64_t bytes) const {
    std::call_once(section.is_read, [&] {
      section.bytes = value_or_throw(file.place, [&] {
        return read_packed_section(*file.source, file.structure->section(name), bytes);
      });
    });
    return section.bytes;
  }

  const BrickFile file;
  const SampleBricks samples;
  std::optional<SpectrumBricks> spectrum;
  const SmallSection coarse;
  const SmallSection ranges;
};

PreparedFile::PreparedFile(const std::string& place, std::shared_ptr<RemoteFiles> files)
    : content_(std::make_shared<const Content>(open_file(place, std::move(files)))) {}

PreparedFile::PreparedFile(const std::string& place, std::shared_ptr<const ByteSource> source)
    : content_(std::make_shared<const Content>(
          with_structure({.place = place,
                          .source = std::move(source),
                          .cache = std::make_shared<MemoryCache>(kOwnCacheBytes)}))) {}

const DatasetMetadata& PreparedFile::metadata() const { return content_->file.structure->metadata; }
const SectionTable& PreparedFile::sections() const { return content_->file.structure->sections; }
std::uint64_t PreparedFile::bytes() const { return content_->file.source->size(); }

std::uint64_t PreparedFile::content_id() const { return content_id_of(sections()); }

// The returned sources own a share of the whole content.
std::shared_ptr<const PreparedBricks> PreparedFile::samples() const {
  return {content_, &content_->samples};
}

std::shared_ptr<const PreparedBricks> PreparedFile::spectrum() const {
  if (!content_->spectrum) return nullptr;
  return {content_, &*content_->spectrum};
}

void PreparedFile::check() const { content_->file.source->check(); }

std::span<const std::byte> PreparedFile::coarse() const {
  return content_->unpacked(content_->coarse, section_names::kCoarse, coarse_bytes(info()));
}

std::span<const std::byte> PreparedFile::ranges() const {
  return content_->unpacked(content_->ranges, section_names::kRanges, ranges_bytes(info()));
}

std::span<const std::byte> PreparedFile::bins() const { return content_->file.structure->bins; }

}  // namespace multitetra
