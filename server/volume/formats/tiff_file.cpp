#include "server/volume/formats/tiff_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/base/number_text.hpp"
#include "common/base/text.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/plain_slices.hpp"
#include "server/volume/formats/detail/tiff_description.hpp"
#include "server/volume/formats/detail/tiff_pages.hpp"
#include "server/volume/formats/endian.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMaxTagBytes = 4096;  // Bytes behind an image that tags may have.

struct PageOfFile {
  fs::path file;
  std::size_t page = 0;
};

void check_page(const fs::path& file, std::size_t page, const TiffPages& tiff) {
  if (page < tiff.count()) return;
  fail_reading(file,
               "its description refers to page " + std::to_string(page + 1) + ", but it has " +
                   std::to_string(tiff.count()) + " pages",
               "Get a complete copy of the file, or save it again as one file");
}

class TiffSlices : public StoredSlices {
 public:
  TiffSlices(fs::path file, TiffPages tiff, std::vector<PageOfFile> pages,
             const ImageHeader& header)
      : file_(std::move(file)), tiff_(std::move(tiff)), pages_(std::move(pages)), header_(header) {}

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    for (std::size_t i = 0; i < count; ++i) {
      const auto& [file, page] = pages_[first + i];
      if (file != file_) {
        tiff_ = TiffPages(file);
        file_ = file;
      }
      check_page(file, page, tiff_);
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
  fs::path file_;  // The one that is open.
  TiffPages tiff_;
  std::vector<PageOfFile> pages_;  // Of each slice.
  ImageHeader header_;
};

// The slices of images that follow each other in the file without directories of their own.
std::unique_ptr<StoredSlices> images_in_one_directory(const fs::path& path, const TiffPages& tiff,
                                                      const std::vector<PageOfFile>& images,
                                                      const ImageHeader& header) {
  SampleParts samples{.part_bytes = header.slice_bytes(),
                      .endian = tiff.is_big_endian() ? Endian::kBig : Endian::kLittle};
  for (const PageOfFile& image : images) {
    samples.parts.push_back(
        {.file = path, .offset = *tiff.plain_offset() + image.page * header.slice_bytes()});
  }
  return slices_in_parts(std::move(samples), header);
}

TiffDescription plain_pages(std::int64_t count) {
  TiffDescription pages{.slices = count};
  for (std::int64_t page = 0; page < count; ++page) {
    pages.pages.push_back(static_cast<std::size_t>(page));
  }
  return pages;
}

// Returns one of the images that tifffile wrote to a file; nothing if each is one page, as of a
// stack that was written page by page.
std::optional<TiffDescription> image_of_tifffile(const fs::path& file, const TiffPages& tiff,
                                                 const std::string& series) {
  const std::vector<TiffPages::Shape>& shapes = tiff.shapes();
  if (shapes.size() < 2 || shapes.size() == tiff.count() || shapes[0].page != 0) {
    return std::nullopt;
  }
  std::vector<std::string> images;
  std::size_t chosen = series.empty() ? 0 : shapes.size();
  const auto end_of = [&](std::size_t image) {
    return image + 1 < shapes.size() ? shapes[image + 1].page : tiff.count();
  };
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    images.push_back("pages " + std::to_string(shapes[i].page + 1) + " to " +
                     std::to_string(end_of(i)));
    if (series == std::to_string(i + 1) || series == images.back()) chosen = i;
  }
  if (chosen == shapes.size()) {
    fail_reading(file, "it has no image " + series,
                 "Choose an image with --series, from 1 to " + std::to_string(shapes.size()));
  }
  const std::size_t begin = shapes[chosen].page;
  const std::size_t pages = end_of(chosen) - begin;
  const ImageHeader header = tiff.header(begin);
  const auto shaped =
      parse_shape(shapes[chosen].text, {header.dims[0], header.dims[1]}, header.components);
  if (shaped && pages == 1 && shaped->pages.size() > 1) {
    fail_reading(file, "its page " + std::to_string(begin + 1) + " has several images",
                 "Save it with a page for each image");
  }
  TiffDescription description = shaped && shaped->pages.size() == pages
                                    ? *shaped
                                    : plain_pages(static_cast<std::int64_t>(pages));
  for (std::size_t& page : description.pages) page += begin;
  description.images = std::move(images);
  description.image = chosen;
  return description;
}

TiffDescription description_of(const fs::path& file, const std::string& text, const TiffPages& tiff,
                               const ImageHeader& header, const std::string& series, bool is_slice,
                               std::vector<std::string>& notices) {
  const auto pages = static_cast<std::int64_t>(tiff.count());
  const TiffDescription plain = plain_pages(pages == 1 ? tiff.images_in_first() : pages);
  if (auto image = is_slice ? std::nullopt : image_of_tifffile(file, tiff, series)) return *image;
  if (const auto shaped = parse_shape(text, {header.dims[0], header.dims[1]}, header.components)) {
    const std::size_t described = shaped->pages.size();
    // Pages behind it are others; those of a shape each are a stack.
    const bool is_one = described == tiff.count() || (described > 1 && described < tiff.count());
    return pages == 1 || is_one ? *shaped : plain;
  }
  const bool is_imagej = text.starts_with("ImageJ=");
  if (!is_imagej && text.find("<OME") == std::string::npos) return plain;
  Result<TiffDescription> description =
      is_imagej ? parse_imagej_description(text)
                : parse_ome_description(text, header.components, series);
  if (is_slice && (!description || description->pages.size() != 1)) {
    notices.push_back(
        "'" + file.string() +
        "': it describes a volume of several images, which is ignored; give this file "
        "alone to read that.");
    return plain;
  }
  if (!description) {
    fail_reading(file, description.error().text,
                 series.empty()
                     ? "Save it again, or as plain pages"
                     : "Choose an image with --series, by its number from 1 or its name");
  }
  return *std::move(description);
}

void place_pages(const TiffPages& tiff, const TiffDescription& description, ImageHeader& header) {
  const TiffPages::Resolution& resolution = tiff.resolution();
  const std::array<double, 2> pixels = {resolution.x, resolution.y};
  StatedNumbers spacing = description.spacing;
  std::array<std::string, 3> units = description.units;
  const TiffPages::Placement& by_tags = tiff.placement();
  if (spacing == kNotStated) {
    spacing = by_tags.spacing;
    units = by_tags.units;
  }
  if (by_tags.missing) {
    header.missing.push_back(*by_tags.missing);
    header.values.missing = Basis::kStated;
  }
  const bool is_screen = resolution.unit_mm == 25.4 && (pixels[0] == 72 || pixels[0] == 96);
  for (std::size_t axis = 0; axis < 2; ++axis) {
    if (spacing[axis] || !std::isfinite(pixels[axis]) || pixels[axis] <= 0) continue;
    if (description.resolution_is_spacing) {
      // As in ImageJ: that along z, in no unit, is in that of the others.
      const bool has_unit = !units[axis].empty() || (resolution.unit_mm == 0 && spacing[2]);
      if (has_unit) spacing[axis] = 1 / pixels[axis];
    } else if (units[axis].empty() && resolution.unit_mm > 0 && !is_screen) {
      spacing[axis] = resolution.unit_mm / pixels[axis];
      units[axis] = "mm";
    }
  }
  StatedNumbers origin = kNotStated;
  for (std::size_t axis = 0; axis < 3 && description.origin_sample; ++axis) {
    if (spacing[axis]) origin[axis] = 0 - (*description.origin_sample)[axis] * *spacing[axis];
  }
  set_box_axes(header, origin, spacing);
  set_units_of_axes(header, units);
  if (by_tags.is_on_map) {
    header.contradictions.push_back({Fact::kOrigin, "its place on a map (GeoTIFF) is not read"});
  }
  if (by_tags.unread.empty() || (spacing[0] && spacing[1] && spacing[2])) return;
  header.contradictions.push_back(
      {Fact::kSpacing, "this is a TIFF file of " + by_tags.unread +
                           ", whose tags are not read; they may state the spacing"});
}

// Sets the values that numbers stand for, as ImageJ or GDAL state it.
void scale_pages(const TiffPages& tiff, const TiffDescription& description, ImageHeader& header) {
  const TiffPages::Scaling& by_tags = tiff.scaling();
  // ImageJ does not calibrate floats.
  const bool is_float = header.type == StoredType::kF32 || header.type == StoredType::kF64;
  const bool is_calibrated = description.slope && !is_float;
  if (const auto slope = is_calibrated ? description.slope : by_tags.slope) {
    header.slope = *slope;
    header.intercept = is_calibrated ? description.intercept : by_tags.intercept;
    header.meaning.value_unit = description.value_unit;
    header.values.scaling = Basis::kStated;
  }
  if ((description.unread_function.empty() || is_float) && !by_tags.differs) return;
  header.contradictions.push_back(
      {Fact::kScaling,
       by_tags.differs ? "its channels have scales of their own (GDAL); they are read as stored"
                       : "its values are calibrated by function " + description.unread_function +
                             " of ImageJ, which is not read; its numbers are read as stored"});
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

// Returns the notice of the bytes behind the only image of a file, if they could be other images.
std::vector<std::string> notices_behind(const fs::path& path, const TiffPages& tiff,
                                        std::int64_t images, const ImageHeader& header) {
  if (tiff.count() != 1 || !tiff.plain_offset() || tiff.has_other_directories()) return {};
  const std::uint64_t end =
      *tiff.plain_offset() + static_cast<std::uint64_t>(images) * header.slice_bytes();
  const std::uint64_t size = InputFile(path).size();
  const std::uint64_t behind = size - std::min(size, end);
  if (behind < header.slice_bytes() || behind < kMaxTagBytes) return {};
  return {unread_notice(path, behind)};
}

// The text that describes pages, and the file that has it.
struct DescriptionText {
  fs::path file;
  std::string text;
};

std::string ome_text_in(const fs::path& file) {
  constexpr std::size_t kMaxXmlBytes = std::size_t{1} << 26;
  const std::string text = InputFile(file).beginning(kMaxXmlBytes);
  return is_ome_xml(text) ? text : TiffPages(file).description();
}

// Returns the files of the pages from `first` on.
std::vector<PageOfFile> pages_in_files(const TiffDescription& description, std::size_t first,
                                       const fs::path& path, const DescriptionText& described,
                                       const VolumeChoice& choice) {
  std::map<std::size_t, fs::path> files;
  std::vector<PageOfFile> pages;
  for (std::size_t i = first; i < first + static_cast<std::size_t>(description.slices); ++i) {
    const std::size_t file = description.files.empty() ? 0 : description.file_of_page[i];
    const std::string name = description.files.empty() ? "" : description.files[file];
    const auto [found, is_new] = files.try_emplace(file);
    if (is_new && description.files.empty()) {
      found->second = path;
    } else if (is_new) {
      found->second = name.empty() || name == described.file.filename()
                          ? described.file
                          : named_data_file(described.file, name, choice.allow_external_files);
    }
    pages.push_back({.file = found->second, .page = description.pages[i]});
  }
  return pages;
}

StoredVolume open_pages(const fs::path& path, DescriptionText described, const VolumeChoice& choice,
                        bool is_slice) {
  TiffPages tiff(path);
  StoredVolume volume{.header = tiff.header(0)};
  ImageHeader& header = volume.header;
  if (described.text.empty()) described = {.file = path, .text = tiff.description()};
  if (const std::string beside = parse_ome_set(described.text).metadata_file;
      !beside.empty() && !is_slice) {
    described.file = named_data_file(path, beside, choice.allow_external_files);
    described.text = ome_text_in(described.file);
  }
  const auto describe = [&] {
    return description_of(path, described.text, tiff, header, choice.series, is_slice,
                          volume.notices);
  };
  TiffDescription description = describe();
  // Images after the first may be of another size and type.
  if (description.image > 0 && description.files.empty() && description.pages[0] < tiff.count()) {
    header = tiff.header(description.pages[0]);
    description = describe();
  }
  header.dims[2] = description.slices;
  place_pages(tiff, description, header);
  scale_pages(tiff, description, header);
  check_header(path, header);
  volume.contents = {.times = description.times, .fields = fields_of_channels(description)};
  offer_images(path, "image", description.images, choice, volume);
  volume.channels = description.channels;
  const FileEntries channels = {
      .count = description.channels,
      .several = "it has " + std::to_string(description.channels) + " channels",
      .remedy = kChooseChannel,
      .missing = "it has no channel"};
  const std::int64_t channel = chosen_entry(path, channels, choice.channel, choice.first);
  const std::int64_t time = chosen_time(path, description.times.count, choice);
  const auto first =
      static_cast<std::size_t>((time * description.channels + channel) * description.slices);
  std::vector<PageOfFile> pages = pages_in_files(description, first, path, described, choice);
  const auto all = static_cast<std::int64_t>(description.pages.size());
  if (tiff.count() == 1 && all > 1 && description.images.empty()) {
    // ImageJ, tifffile and MetaMorph write stacks as one page, followed by the samples of others.
    if (!tiff.plain_offset()) {
      fail_reading(
          path,
          "its only page has " + std::to_string(all) +
              " images, which are compressed, in tiles or not stored as they are to be read",
          "Save it with a page for each image, or without compression");
    }
    volume.slices = images_in_one_directory(path, tiff, pages, header);
    return volume;
  }
  for (const auto& [file, page] : pages) {
    if (file == path) check_page(path, page, tiff);
  }
  if (const std::size_t unread =
          tiff.count() > description.pages.size() ? tiff.count() - description.pages.size() : 0;
      unread > 0 && !is_slice && description.images.size() < 2 && description.files.empty()) {
    volume.notices.push_back("'" + path.string() + "': skipped " + counted(unread, "page") +
                             " that its description omits.");
  }
  for (std::string& notice : notices_behind(path, tiff, all, header)) {
    volume.notices.push_back(std::move(notice));
  }
  volume.slices = std::make_unique<TiffSlices>(path, std::move(tiff), std::move(pages), header);
  return volume;
}

}  // namespace

StoredVolume open_tiff(const fs::path& path, const VolumeChoice& choice) {
  const std::string beginning = InputFile(path).beginning(kMaxTagBytes);
  if (!is_ome_xml(beginning)) return open_pages(path, {}, choice, /*is_slice=*/false);
  const DescriptionText described = {.file = path, .text = ome_text_in(path)};
  const std::string first = parse_ome_set(described.text).first_file;
  if (first.empty()) {
    fail_reading(
        path, "it is a description by OME without names of TIFF files",
        "Give the files that it describes, or convert them to OME-TIFF, as with bfconvert");
  }
  return open_pages(named_data_file(path, first, choice.allow_external_files), described, choice,
                    /*is_slice=*/false);
}

StoredVolume open_tiff_slice(const fs::path& path) {
  return open_pages(path, {}, {}, /*is_slice=*/true);
}

}  // namespace multitetra
