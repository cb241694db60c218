#include "server/dataset/objects/object_folder.hpp"

#include <algorithm>
#include <cassert>
#include <string>
#include <system_error>
#include <utility>

#include "common/base/atomic_file.hpp"
#include "server/dataset/byte_source.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

template <typename Action>
auto in_folder(const Action& action) {
  try {
    return action();
  } catch (const std::system_error& error) {
    throw DatasetFileError(std::string(error.what()) + ".");
  }
}

}  // namespace

ObjectFolder::ObjectFolder(const fs::path& folder, bool shares_objects)
    : folder_(folder),
      objects_(shares_objects ? folder / ".." : folder),
      shares_objects_(shares_objects) {
  in_folder([&] {
    fs::create_directories(folder_);
    fs::create_directories(objects_ / "objects");
  });
}

ObjectName ObjectFolder::put(std::span<const std::byte> bytes) const {
  assert(!bytes.empty() && bytes.size() <= kMostObjectBytes);
  const ObjectName name = name_of(bytes);
  const fs::path path = objects_ / name.key();
  std::error_code missing;
  if (fs::file_size(path, missing) == name.size && !missing) return name;
  in_folder([&] {
    fs::create_directories(path.parent_path());
    AtomicFile file(path);
    file.write_at(0, bytes);
    file.commit(Durability::kMachineStop);
  });
  new_bytes_ += name.size;
  return name;
}

void ObjectFolder::finish(const Manifest& manifest) const {
  assert(manifest.shares_objects == shares_objects_);
  const std::string text = manifest_text(manifest);
  in_folder([&] {
    AtomicFile file(folder_ / kManifestName);
    file.write_at(0, std::as_bytes(std::span(text)));
    file.commit(Durability::kMachineStop);
  });
}

std::uint64_t ObjectFolder::remove_others(std::vector<ObjectName> used) const {
  std::vector<fs::path> names;
  for (const ObjectName& name : used) names.push_back(name.hex());
  std::sort(names.begin(), names.end());
  std::uint64_t bytes = 0;
  in_folder([&] {
    for (const auto& entry : fs::recursive_directory_iterator(objects_ / "objects")) {
      if (!entry.is_regular_file() || entry.path().filename().string().size() != 64 ||
          std::binary_search(names.begin(), names.end(), entry.path().filename())) {
        continue;
      }
      bytes += entry.file_size();
      fs::remove(entry.path());
    }
  });
  return bytes;
}

void RunWriter::add(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const std::size_t count = std::min<std::size_t>(bytes.size(), kRunObjectBytes - buffer_.size());
    buffer_.insert(buffer_.end(), bytes.begin(),
                   bytes.begin() + static_cast<std::ptrdiff_t>(count));
    bytes = bytes.subspan(count);
    run_.bytes += count;
    if (buffer_.size() < kRunObjectBytes) continue;
    run_.objects.push_back(folder_.put(buffer_));
    buffer_.clear();
  }
}

ObjectRun RunWriter::finish() {
  if (!buffer_.empty()) run_.objects.push_back(folder_.put(buffer_));
  buffer_.clear();
  return std::move(run_);
}

}  // namespace multitetra
