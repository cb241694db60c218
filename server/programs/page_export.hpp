// A page without a server: the viewer, prepared files and an index of them in a folder, for any web
// space that answers requests for ranges.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace multitetra {

struct ExportedPage {
  std::uint64_t datasets = 0;
  std::uint64_t files = 0;
  std::uint64_t bytes = 0;
};

// Writes the page of a prepared file, or of all in a folder; replaces files of the same names.
// Throws std::runtime_error if the viewer is not installed, if two datasets have the same name, or
// if there is none; and what reading and writing files throws.
ExportedPage export_page(const std::string& datasets, const std::filesystem::path& folder);

}  // namespace multitetra
