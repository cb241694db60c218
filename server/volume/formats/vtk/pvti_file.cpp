#include "server/volume/formats/vtk/pvti_file.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/vtk/detail/vti_header.hpp"
#include "server/volume/formats/vtk/vti_file.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

// A piece, and the position of its first sample in the whole.
struct PlacedPiece {
  fs::path file;
  std::array<std::int64_t, 3> at{};
  std::array<std::int64_t, 3> dims{};
};

class PvtiSlices : public StoredSlices {
 public:
  PvtiSlices(std::vector<PlacedPiece> pieces, VolumeChoice choice, const ImageHeader& header)
      : pieces_(std::move(pieces)), choice_(std::move(choice)), header_(header) {
    open_.resize(pieces_.size());
  }

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    const auto begin = static_cast<std::int64_t>(first);
    const auto end = static_cast<std::int64_t>(first + count);
    for (std::size_t p = 0; p < pieces_.size(); ++p) {
      const PlacedPiece& piece = pieces_[p];
      const std::int64_t low = std::max(begin, piece.at[2]);
      const std::int64_t high = std::min(end, piece.at[2] + piece.dims[2]);
      for (std::int64_t z = low; z < high; ++z) {
        copy_slice(p, z, into + static_cast<std::size_t>(z - begin) * header_.slice_bytes());
      }
    }
  }

 private:
  void copy_slice(std::size_t number, std::int64_t z, std::byte* into) {
    const PlacedPiece& piece = pieces_[number];
    const auto sample = static_cast<std::int64_t>(bytes_of(header_.type)) * header_.components;
    const auto row = static_cast<std::size_t>(piece.dims[0] * sample);
    slice_.resize(row * static_cast<std::size_t>(piece.dims[1]));
    slices_of(number).read(static_cast<std::size_t>(z - piece.at[2]), 1, slice_.data());
    for (std::int64_t y = 0; y < piece.dims[1]; ++y) {
      const std::int64_t to = ((piece.at[1] + y) * header_.dims[0] + piece.at[0]) * sample;
      std::memcpy(into + to, slice_.data() + static_cast<std::size_t>(y) * row, row);
    }
  }

  // Opens pieces on demand and limits the number of open ones.
  StoredSlices& slices_of(std::size_t number) {
    constexpr std::size_t kMaxOpen = 64;
    if (!open_[number]) {
      if (opened_.size() == kMaxOpen) {
        open_[opened_.front()].reset();
        opened_.erase(opened_.begin());
      }
      open_[number] = std::move(open_vti_piece(pieces_[number].file, choice_).volume.slices);
      opened_.push_back(number);
    }
    return *open_[number];
  }

  std::vector<PlacedPiece> pieces_;
  VolumeChoice choice_;
  ImageHeader header_;
  std::vector<std::unique_ptr<StoredSlices>> open_;
  std::vector<std::size_t> opened_;  // Open pieces, oldest first.
  std::vector<std::byte> slice_;
};

// Throws unless the pieces cover every sample: their borders cut the whole into boxes to check.
void check_cover(const fs::path& path, const std::vector<PlacedPiece>& pieces,
                 const std::array<std::int64_t, 3>& dims) {
  std::array<std::vector<std::int64_t>, 3> cuts;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    cuts[axis] = {0, dims[axis]};
    for (const PlacedPiece& piece : pieces) {
      cuts[axis].push_back(piece.at[axis]);
      cuts[axis].push_back(piece.at[axis] + piece.dims[axis]);
    }
    std::sort(cuts[axis].begin(), cuts[axis].end());
    cuts[axis].erase(std::unique(cuts[axis].begin(), cuts[axis].end()), cuts[axis].end());
  }
  std::vector<bool> is_covered((cuts[0].size() - 1) * (cuts[1].size() - 1) * (cuts[2].size() - 1));
  const auto index = [&](std::size_t axis, std::int64_t at) {
    const auto found = std::lower_bound(cuts[axis].begin(), cuts[axis].end(), at);
    return static_cast<std::size_t>(found - cuts[axis].begin());
  };
  for (const PlacedPiece& piece : pieces) {
    for (std::size_t z = index(2, piece.at[2]); z < index(2, piece.at[2] + piece.dims[2]); ++z) {
      for (std::size_t y = index(1, piece.at[1]); y < index(1, piece.at[1] + piece.dims[1]); ++y) {
        for (std::size_t x = index(0, piece.at[0]); x < index(0, piece.at[0] + piece.dims[0]);
             ++x) {
          is_covered[(z * (cuts[1].size() - 1) + y) * (cuts[0].size() - 1) + x] = true;
        }
      }
    }
  }
  if (std::find(is_covered.begin(), is_covered.end(), false) == is_covered.end()) return;
  fail_reading(path, "its pieces do not cover its whole extent", "Get all pieces");
}

}  // namespace

StoredVolume open_pvti(const fs::path& path, const VolumeChoice& choice) {
  constexpr std::size_t kMaxPieces = 4096;
  constexpr std::size_t kMaxBytes = std::size_t{1} << 24;
  const InputFile file(path);
  std::string text = file.beginning(kMaxBytes);
  const Result<PvtiHeader> parsed = parse_pvti(text);
  if (!parsed) fail_reading(path, parsed.error().text, "Save it again");
  if (parsed->pieces.empty() || parsed->pieces.size() > kMaxPieces) {
    fail_reading(path, "it has " + std::to_string(parsed->pieces.size()) + " pieces",
                 "Save it as 1 to " + std::to_string(kMaxPieces) + " pieces");
  }
  std::vector<PlacedPiece> pieces;
  StoredVolume volume{.header = {.values = kNumbersAsStored}};  // Replaced by the first piece.
  bool of_cells = false;
  const auto side_of_all = [&](std::size_t axis) {
    const std::int64_t cells = parsed->extent[2 * axis + 1] - parsed->extent[2 * axis];
    return of_cells ? std::max<std::int64_t>(cells, 1) : cells + 1;  // Cells of a flat image, too.
  };
  for (const std::string& source : parsed->pieces) {
    const fs::path piece_file = named_data_file(path, source, choice.allow_external_files);
    VtiPiece piece = open_vti_piece(piece_file, choice);
    const ImageHeader& header = piece.volume.header;
    if (pieces.empty()) {
      volume = std::move(piece.volume);
      of_cells = piece.of_cells;
    } else if (header.type != volume.header.type || of_cells != piece.of_cells ||
               header.components != volume.header.components) {
      fail_reading(piece_file, "the type of its samples differs from that of other pieces",
                   "Save all pieces with the same type");
    }
    PlacedPiece& placed = pieces.emplace_back(PlacedPiece{.file = piece_file});
    for (std::size_t axis = 0; axis < 3; ++axis) {
      placed.at[axis] = piece.extent[2 * axis] - parsed->extent[2 * axis];
      placed.dims[axis] = (pieces.size() == 1 ? volume.header : header).dims[axis];
      if (placed.at[axis] < 0 || placed.at[axis] + placed.dims[axis] > side_of_all(axis)) {
        fail_reading(piece_file, "it is outside the whole extent", "Save it again");
      }
    }
  }
  ImageHeader& header = volume.header;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    header.dims[axis] = side_of_all(axis);
    const Vec3& step = header.geometry.axes[axis];
    for (std::size_t row = 0; row < 3; ++row) {
      std::optional<double>& origin = header.geometry.origin[row];
      if (origin) *origin -= step[row] * static_cast<double>(pieces.front().at[axis]);
    }
  }
  check_header(path, header);
  check_cover(path, pieces, header.dims);
  volume.slices = std::make_unique<PvtiSlices>(std::move(pieces), choice, header);
  return volume;
}

}  // namespace multitetra
