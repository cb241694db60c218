#include "server/dataset/detail/prepared_sinks.hpp"

#include "common/base/scratch_file.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"

namespace multitetra {

FileSink::FileSink(const std::filesystem::path& path, const DatasetInfo& info)
    : writer_(
          path,
          {.dims = info.dims, .type = info.type, .spectrum_bricks = SpectrumLayout(info).size()}),
      folder_(path.parent_path()) {}

std::unique_ptr<Scratch> FileSink::new_scratch() const {
  return std::make_unique<ScratchFile>(folder_);
}

}  // namespace multitetra
