// Prepares datasets for one test; their files are deleted when they are open.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "server/dataset/prepare.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/volume_in_memory.hpp"

namespace multitetra {

[[nodiscard]] inline DatasetPtr make_dataset(VolumeSource& source, const PrepareOptions& options) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "dataset.mtd";
  prepare(source, options, file, {});
  return open_dataset(file.string());
}

[[nodiscard]] inline DatasetPtr make_dataset(Volume volume, std::string name,
                                             std::optional<double> outside = std::nullopt,
                                             std::int32_t margin = 0) {
  return make_dataset(*source_of(std::move(volume)),
                      {.name = std::move(name), .outside = outside, .margin = margin});
}

}  // namespace multitetra
