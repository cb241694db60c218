#include "server/dataset/nrrd_header.hpp"

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <vector>

#include "server/dataset/nrrd_lines.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxNrrdHeaderBytes = std::size_t{1} << 20;

}  // namespace

std::optional<std::string> rewritten_nrrd_header(std::string_view header, const fs::path& file) {
  NrrdLines nrrd(header);
  std::vector<std::string>& lines = nrrd.lines();
  if (lines.empty() || !lines[0].starts_with("NRRD")) return std::nullopt;
  const std::ptrdiff_t named = nrrd.position("space");
  const std::ptrdiff_t space = named >= 0 ? named : nrrd.position("space dimension");
  const std::ptrdiff_t directions = nrrd.position("space directions");
  const std::ptrdiff_t origin = nrrd.position("space origin");
  const bool only_spacings = space >= 0 && directions < 0 && nrrd.position("spacings") >= 0;
  const bool too_late = (directions >= 0 && directions < space) || (origin >= 0 && origin < space);
  const bool missing = space < 0 && (directions >= 0 || origin >= 0);
  if (!only_spacings && !too_late && !missing) return std::nullopt;

  nrrd.detach(file);
  if (only_spacings) {
    lines.erase(lines.begin() + space);
    nrrd.remove("space origin");
  } else if (missing) {
    lines.insert(lines.begin() + 1, "space dimension: 3");
  } else {
    std::rotate(lines.begin() + 1, lines.begin() + space, lines.begin() + space + 1);
  }
  return nrrd.text();
}

std::string read_nrrd_header(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string header;
  std::string line;
  while (header.size() < kMaxNrrdHeaderBytes && std::getline(in, line)) {
    if (line.empty() || line == "\r") break;
    header += line + "\n";
  }
  return header;
}

}  // namespace multitetra
