#include "server/dataset/prepared_file.hpp"

#include <new>
#include <span>
#include <utility>

#include "server/dataset/byte_source.hpp"
#include "server/dataset/mapped_file.hpp"

namespace multitetra {
namespace {

std::shared_ptr<const PreparedStructure> structure_of(const std::filesystem::path& path,
                                                      const FileSource& file) {
  try {
    auto structure = decode_structure(file);
    if (!structure) throw DatasetFileError(path, structure.error().text);
    return std::make_shared<const PreparedStructure>(*std::move(structure));
  } catch (const std::bad_alloc&) {
    throw DatasetFileError(path, "there is not enough memory for its index.");
  }
}

}  // namespace

struct PreparedFile::Content {
  Content(const std::filesystem::path& path, const FileSource& file)
      : structure(structure_of(path, file)),
        memory(file),
        samples(path, memory.bytes(), structure, &memory),
        spectrum(path, memory.bytes(), structure, &memory) {}

  [[nodiscard]] std::span<const std::byte> bytes_of(const char* section_name) const {
    const Section& section = structure->section(section_name);
    return memory.bytes().subspan(section.offset, section.size);
  }

  const std::shared_ptr<const PreparedStructure> structure;
  const MappedFile memory;
  const SampleBricks samples;
  const SpectrumBricks spectrum;
};

PreparedFile::PreparedFile(const std::filesystem::path& path)
    : content_(std::make_shared<const Content>(path, FileSource(path))) {}

const DatasetMetadata& PreparedFile::metadata() const { return content_->structure->metadata; }

std::uint64_t PreparedFile::content_id() const {
  return content_id_of(content_->structure->sections);
}

// The sources share the ownership of the whole content.
std::shared_ptr<const PreparedBricks> PreparedFile::samples() const {
  return {content_, &content_->samples};
}

std::shared_ptr<const PreparedBricks> PreparedFile::spectrum() const {
  return {content_, &content_->spectrum};
}

void PreparedFile::check() const { content_->memory.check(); }

std::span<const std::byte> PreparedFile::coarse() const {
  return content_->bytes_of(section_names::kCoarse);
}

std::span<const std::byte> PreparedFile::ranges() const {
  return content_->bytes_of(section_names::kRanges);
}

std::span<const std::byte> PreparedFile::bins() const {
  return content_->bytes_of(section_names::kBins);
}

}  // namespace multitetra
