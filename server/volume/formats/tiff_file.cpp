#include "server/volume/formats/tiff_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/base/text.hpp"
#include "server/volume/formats/detail/plain_slices.hpp"
#include "server/volume/formats/detail/tiff_description.hpp"
#include "server/volume/formats/detail/tiff_pages.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

class TiffSlices : public StoredSlices {
 public:
  TiffSlices(fs::path file, TiffPages tiff, std::vector<std::size_t> pages,
             const ImageHeader& header)
      : file_(std::move(file)), tiff_(std::move(tiff)), pages_(std::move(pages)), header_(header) {}

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t page = pages_[first + i];
      const ImageHeader own = tiff_.header(page);
      if (own.dims[0] != header_.dims[0] || own.dims[1] != header_.dims[1] ||
          own.type != header_.type || own.components != header_.components) {
        fail_reading(file_,
                     "its page " + std::to_string(page + 1) +
                         " has another size or type than the first page",
                     "All pages must have the same size and type; save others in a separate file");
      }
      tiff_.read(page, into + i * header_.slice_bytes());
    }
  }

 private:
  fs::path file_;
  TiffPages tiff_;
  // Page of each slice.
  std::vector<std::size_t> pages_;
  ImageHeader header_;
};

TiffDescription plain_pages(const TiffPages& tiff) {
  TiffDescription pages{.slices = static_cast<std::int64_t>(tiff.count())};
  for (std::size_t page = 0; page < tiff.count(); ++page) pages.pages.push_back(page);
  return pages;
}

TiffDescription description_of(const fs::path& file, const TiffPages& tiff, std::int64_t components,
                               bool is_slice) {
  const std::string& text = tiff.description();
  const bool is_imagej = text.starts_with("ImageJ=");
  if (!is_imagej && text.find("<OME") == std::string::npos) return plain_pages(tiff);
  Result<TiffDescription> description =
      is_imagej ? parse_imagej_description(text) : parse_ome_description(text, components);
  if (is_slice && (!description || description->pages.size() != 1)) return plain_pages(tiff);
  if (!description) {
    fail_reading(file, description.error().text, "Save it again, or as plain pages");
  }
  return *std::move(description);
}

void place_pages(const TiffPages& tiff, const TiffDescription& description, ImageHeader& header) {
  const TiffPages::Resolution& resolution = tiff.resolution();
  std::array<double, 2> pixels = {resolution.x, resolution.y};
  StatedNumbers spacing = kNotStated;
  const bool is_screen = resolution.unit_mm == 25.4 && (pixels[0] == 72 || pixels[0] == 96);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (description.spacing[axis]) {
      spacing[axis] = *description.spacing[axis];
    } else if (axis < 2 && std::isfinite(pixels[axis]) && pixels[axis] > 0) {
      if (description.resolution_is_spacing) {
        if (!description.length_unit.empty()) spacing[axis] = 1 / pixels[axis];
      } else if (description.length_unit.empty() && resolution.unit_mm > 0 && !is_screen) {
        spacing[axis] = resolution.unit_mm / pixels[axis];
        header.meaning.length_unit = "mm";
      }
    }
  }
  if (!description.length_unit.empty()) header.meaning.length_unit = description.length_unit;
  set_box_axes(header, kNotStated, spacing);
}

std::vector<SourceField> fields_of_channels(const TiffDescription& description) {
  std::vector<SourceField> fields;
  for (std::int64_t channel = 0; description.channels > 1 && channel < description.channels;
       ++channel) {
    const auto index = static_cast<std::size_t>(channel);
    const TiffChannel described = index < description.described_channels.size()
                                      ? description.described_channels[index]
                                      : TiffChannel();
    std::string name = member_name_from(described.name);
    if (name.empty()) name = "channel" + std::to_string(channel);
    fields.push_back({.name = std::move(name), .channel = channel, .color = described.color});
  }
  return fields;
}

StoredVolume open_pages(const fs::path& path, const VolumeChoice& choice, bool is_slice) {
  TiffPages tiff(path);
  StoredVolume volume{.header = tiff.header(0)};
  ImageHeader& header = volume.header;
  const TiffDescription description = description_of(path, tiff, header.components, is_slice);
  header.dims[2] = description.slices;
  place_pages(tiff, description, header);
  check_header(path, header);
  volume.contents = {.times = description.times, .fields = fields_of_channels(description)};
  volume.channels = description.channels;
  const FileEntries channels = {
      .count = description.channels,
      .several = "it has " + std::to_string(description.channels) + " channels",
      .remedy = kChooseChannel,
      .missing = "it has no channel"};
  const std::int64_t channel = chosen_entry(path, channels, choice.channel, choice.first);
  const std::int64_t time = chosen_time(path, description.times.count, choice);
  const auto first =
      description.pages.begin() + (time * description.channels + channel) * description.slices;
  std::vector<std::size_t> pages(first, first + description.slices);
  const std::size_t last = *std::max_element(pages.begin(), pages.end());
  if (last >= tiff.count()) {
    // ImageJ writes stacks beyond 4 GiB as one page, followed by the samples of the others.
    if (tiff.count() != 1 || !description.resolution_is_spacing || !tiff.plain_offset() ||
        description.channels > 1) {
      fail_damaged(path, "its description refers to more than its " + std::to_string(tiff.count()) +
                             " pages");
    }
    const std::uint64_t before = pages.front() * header.slice_bytes();
    volume.slices = plain_slices(path, *tiff.plain_offset() + before,
                                 tiff.is_big_endian() ? Endian::kBig : Endian::kLittle, header);
    return volume;
  }
  volume.slices = std::make_unique<TiffSlices>(path, std::move(tiff), std::move(pages), header);
  return volume;
}

}  // namespace

StoredVolume open_tiff(const fs::path& path, const VolumeChoice& choice) {
  return open_pages(path, choice, /*is_slice=*/false);
}

StoredVolume open_tiff_slice(const fs::path& path) {
  return open_pages(path, {}, /*is_slice=*/true);
}

}  // namespace multitetra
