#include "server/volume/formats/detail/tiff_description.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "common/base/json.hpp"
#include "common/base/parse_number.hpp"
#include "common/base/text.hpp"
#include "server/volume/formats/detail/numbered_files.hpp"
#include "server/volume/formats/detail/xml_document.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {
namespace {

constexpr std::int64_t kMaxTiffPages = std::int64_t{1} << 24;

tl::unexpected<Error> no_description(const std::string& problem) {
  return fail(ErrorCode::kInvalidArgument, problem);
}

using Values = XmlAttributes;

std::string text_of_value(const Values& values, std::string_view name) {
  const auto found = values.find(name);
  return found == values.end() ? std::string() : found->second;
}

// Returns a positive count; 1 if it is missing, 0 if it is invalid.
std::int64_t count_of(const Values& values, std::string_view name) {
  const std::string text = text_of_value(values, name);
  if (text.empty()) return 1;
  const std::int64_t count = integer(text).value_or(0);
  return count <= kMaxTiffPages ? std::max<std::int64_t>(count, 0) : 0;
}

std::optional<double> length_of(const Values& values, std::string_view name) {
  const std::optional<double> length = finite_number(text_of_value(values, name));
  return length && *length > 0 ? length : std::nullopt;
}

// Sets the pages if slice, channel and time vary in this order ("ZCT": slice fastest).
Result<void> order_pages(TiffDescription& description, std::string_view order) {
  const std::int64_t slices = description.slices;
  const std::int64_t channels = description.channels;
  const std::int64_t times = description.times.count;
  if (slices < 1 || channels < 1 || times < 1 || slices * channels > kMaxTiffPages ||
      slices * channels * times > kMaxTiffPages) {
    return no_description("its counts of slices, channels and times are invalid");
  }
  const auto step = [&](char axis) {
    std::int64_t pages = 1;
    for (const char faster : order.substr(0, order.find(axis))) {
      pages *= faster == 'Z' ? slices : faster == 'C' ? channels : times;
    }
    return pages;
  };
  for (std::int64_t t = 0; t < times; ++t) {
    for (std::int64_t c = 0; c < channels; ++c) {
      for (std::int64_t z = 0; z < slices; ++z) {
        description.pages.push_back(
            static_cast<std::size_t>(t * step('T') + c * step('C') + z * step('Z')));
      }
    }
  }
  return {};
}

// ImageJ escapes non-ASCII characters: \u00B5m.
std::string imagej_unit(std::string text) {
  const std::size_t at = text.find("\\u00B5");
  if (at != std::string::npos) text.replace(at, 6, "µ");
  if (!text.empty() && text[0] == '\xB5') text.replace(0, 1, "µ");  // The micro sign in Latin-1.
  return unit_from(text);
}

// Returns an attribute of Pixels, or its default.
std::string pixels_text(const XmlElement& pixels, std::string_view attribute,
                        const std::string& otherwise) {
  const std::string text = pixels.attribute(attribute);
  return text.empty() ? otherwise : text;
}

std::int64_t count_of_first(const Values& values, std::string_view name) {
  const std::string text = text_of_value(values, name);
  return text.empty() ? 0 : integer(text).value_or(-1);
}

constexpr std::size_t kNoFile = ~std::size_t{0};

std::size_t index_of(const std::string& name, const std::vector<std::string>& names) {
  return static_cast<std::size_t>(std::ranges::lower_bound(names, name) - names.begin());
}

// Places the blocks of pages that specify their first page; others follow `first_page`.
Result<void> place_blocks(const XmlElement& pixels, std::size_t first_page,
                          TiffDescription& description) {
  const std::vector<std::size_t> ordered = description.pages;
  // Position of each page in the order.
  std::vector<std::size_t> place_of(ordered.size());
  for (std::size_t i = 0; i < ordered.size(); ++i) place_of[ordered[i]] = i;
  for (std::size_t& page : description.pages) page += first_page;
  const std::vector<const XmlElement*> blocks = pixels.all("TiffData");
  std::vector<bool> is_placed(ordered.size());
  for (const XmlElement* const element : blocks) {
    const Values& block = element->attributes;
    const XmlElement* const uuid = element->child("UUID");
    const std::string name = uuid == nullptr ? std::string() : uuid->attribute("FileName");
    const bool is_in_set = !description.files.empty();
    if (!block.contains("IFD") && name.empty()) continue;
    const std::size_t file = is_in_set ? index_of(name, description.files) : 0;
    const std::int64_t z = count_of_first(block, "FirstZ");
    const std::int64_t c = count_of_first(block, "FirstC");
    const std::int64_t t = count_of_first(block, "FirstT");
    const std::int64_t page = count_of_first(block, "IFD");
    const bool has_rest = blocks.size() == 1 && !block.contains("IFD");  // All pages of its file.
    const std::int64_t count = block.contains("PlaneCount") ? count_of(block, "PlaneCount")
                               : has_rest                   ? std::ssize(ordered)
                                                            : 1;
    if (z < 0 || z >= description.slices || c < 0 || c >= description.channels || t < 0 ||
        t >= description.times.count || page < 0 || page > kMaxTiffPages) {
      return no_description("its description has pages of slices that do not exist");
    }
    const auto first =
        static_cast<std::size_t>((t * description.channels + c) * description.slices + z);
    // The block continues in the order of pages.
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      if (ordered[first] + i >= ordered.size()) break;
      const std::size_t place = place_of[ordered[first] + i];
      description.pages[place] = static_cast<std::size_t>(page) + i;
      is_placed[place] = true;
      if (is_in_set) description.file_of_page[place] = file;
    }
  }
  // Several blocks that say where their pages are, but not all: an acquisition was stopped.
  const auto placed = std::ranges::count(is_placed, true);
  if (description.files.empty() && blocks.size() > 1 && placed > 0 &&
      placed < std::ssize(is_placed)) {
    return no_description("it has pages for only " + std::to_string(placed) + " of the " +
                          std::to_string(is_placed.size()) + " slices that it describes");
  }
  if (std::ranges::find(description.file_of_page, kNoFile) == description.file_of_page.end()) {
    return {};
  }
  return no_description("its description does not say in which file some of its slices are");
}

// Returns the attribute Color: a signed number whose bytes are red, green, blue and alpha.
std::optional<std::uint32_t> ome_color(const XmlElement& channel) {
  const auto rgba = parse_number<std::int32_t>(channel.attribute("Color"));
  return rgba ? std::optional(static_cast<std::uint32_t>(*rgba) >> 8) : std::nullopt;
}

// Describes an image whose pages begin at `first_page`, unless it says otherwise.
Result<TiffDescription> described(const XmlElement& pixels, std::int64_t components,
                                  std::size_t first_page, std::vector<std::string> files) {
  TiffDescription description{.files = std::move(files)};
  description.slices = count_of(pixels.attributes, "SizeZ");
  description.channels = count_of(pixels.attributes, "SizeC");
  // A page may contain several channels as components of its samples.
  if (components > 1 && description.channels % components == 0) description.channels /= components;
  description.times = even_times(count_of(pixels.attributes, "SizeT"), 0,
                                 length_of(pixels.attributes, "TimeIncrement").value_or(0),
                                 pixels_text(pixels, "TimeIncrementUnit", "s"));
  const std::string order = pixels_text(pixels, "DimensionOrder", "XYZCT");
  if (!order.starts_with("XY") || !std::ranges::is_permutation(order, std::string_view("XYZCT"))) {
    return no_description("its DimensionOrder is neither XYZCT nor XY with another order of ZCT");
  }
  if (const auto done = order_pages(description, std::string_view(order).substr(2)); !done) {
    return tl::unexpected(done.error());
  }
  const std::vector<const XmlElement*> channels = pixels.all("Channel");
  if (std::ssize(channels) == description.channels) {
    for (const XmlElement* const channel : channels) {
      description.described_channels.push_back(
          {.name = channel->attribute("Name"), .color = ome_color(*channel)});
    }
  }
  if (!description.files.empty())
    description.file_of_page.assign(description.pages.size(), kNoFile);
  if (const auto done = place_blocks(pixels, first_page, description); !done) {
    return tl::unexpected(done.error());
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string name = std::string("PhysicalSize") + "XYZ"[axis];
    description.spacing[axis] = length_of(pixels.attributes, name);
    if (description.spacing[axis])
      description.units[axis] = pixels_text(pixels, name + "Unit", "µm");
  }
  return description;
}

// Returns the sorted names of the files that have pages. A single one may have been renamed.
std::vector<std::string> files_of(const XmlElement& ome) {
  std::set<std::string> names;
  for (const XmlElement* const uuid : ome.all("UUID")) {
    const std::string name = uuid->attribute("FileName");
    if (!name.empty()) names.insert(name);
  }
  return {names.begin(), names.end()};
}

// ImageJ's calibration: a line (0), no function (20), or others.
void set_calibration(const Values& values, TiffDescription& description) {
  const std::string function = text_of_value(values, "cf");
  const auto slope = finite_number(text_of_value(values, "c1"));
  const auto intercept = finite_number(text_of_value(values, "c0"));
  if (function.empty() || function == "20") return;
  if (function == "0" && slope && intercept && *slope != 0 && text_of_value(values, "c2").empty()) {
    description.slope = slope;
    description.intercept = *intercept;
    description.value_unit = unit_from(text_of_value(values, "vunit"));
  } else {
    description.unread_function = function;
  }
}

// In samples; what is not stated is 0.
std::optional<Vec3> imagej_origin(const Values& values) {
  Vec3 origin{};
  bool is_stated = false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto number =
        finite_number(text_of_value(values, std::string(1, "xyz"[axis]) + "origin"));
    is_stated = is_stated || number;
    origin[axis] = number.value_or(0);
  }
  return is_stated ? std::optional(origin) : std::nullopt;
}

}  // namespace

Result<TiffDescription> parse_imagej_description(std::string_view text) {
  Values values;
  while (!text.empty()) {
    const std::string_view line = take_line(text);
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) continue;
    values[std::string(trimmed(line.substr(0, equals)))] = trimmed(line.substr(equals + 1));
  }
  TiffDescription description;
  description.channels = count_of(values, "channels");
  const std::int64_t frames = count_of(values, "frames");
  const std::int64_t images = count_of(values, "images");
  description.slices = count_of(values, "slices");
  // A stack that is no hyperstack gives only the number of images.
  if (description.channels == 1 && frames == 1 && description.slices == 1) {
    description.slices = images;
  }
  description.times =
      even_times(frames, 0, length_of(values, "finterval").value_or(0),
                 text_of_value(values, "tunit").empty() ? "s" : text_of_value(values, "tunit"));
  description.times.count = frames;
  constexpr std::array<std::string_view, 3> kUnits = {"unit", "yunit", "zunit"};
  for (std::size_t axis = 0; axis < 3; ++axis) {  // Those along y and z only if they differ.
    const std::string own = text_of_value(values, kUnits[axis]);
    description.units[axis] = imagej_unit(own.empty() ? text_of_value(values, "unit") : own);
  }
  description.resolution_is_spacing = true;
  // ImageJ uses the absolute value.
  const std::optional<double> spacing = finite_number(text_of_value(values, "spacing"));
  if (spacing && *spacing != 0) description.spacing[2] = std::abs(*spacing);
  description.origin_sample = imagej_origin(values);
  set_calibration(values, description);
  if (const auto done = order_pages(description, "CZT"); !done) return tl::unexpected(done.error());
  return description;
}

bool is_ome_xml(std::string_view beginning) {
  return beginning.starts_with('<') &&
         beginning.find("openmicroscopy.org/Schemas/OME") != std::string_view::npos;
}

OmeSet parse_ome_set(std::string_view text) {
  const Result<XmlElement> ome = parse_xml(text);
  if (!ome) return {};
  const XmlElement* const binary = ome->child("BinaryOnly");
  if (binary != nullptr) return {.metadata_file = binary->attribute("MetadataFile")};
  const std::vector<std::string> files = files_of(*ome);
  return {.first_file = files.empty() ? std::string() : files.front()};
}

Result<TiffDescription> parse_ome_description(std::string_view text, std::int64_t components,
                                              std::string_view wanted) {
  const Result<XmlElement> ome = parse_xml(text);
  if (!ome) return no_description("of its description, " + ome.error().text);
  std::vector<std::string> files = files_of(*ome);
  if (files.size() < 2) files.clear();
  if (!files.empty()) files.insert(files.begin(), "");
  std::vector<const XmlElement*> images = ome->all("Image");
  std::erase_if(images, [](const XmlElement* image) { return image->child("Pixels") == nullptr; });
  if (images.empty()) return no_description("its description has no Pixels");
  std::vector<std::string> names;
  std::size_t chosen = wanted.empty() ? 0 : images.size();
  for (std::size_t i = 0; i < images.size(); ++i) {
    const std::string id = images[i]->attribute("ID");
    const std::string name = member_name_from(images[i]->attribute("Name"));
    names.push_back(name.empty() ? id : name);
    const bool is_wanted = wanted == std::to_string(i + 1) || wanted == id || wanted == name;
    if (is_wanted && chosen == images.size()) chosen = i;
  }
  if (chosen == images.size()) {
    std::string list;
    for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
    return no_description("it has no image " + std::string(wanted) + "; there are " + list);
  }
  // Images whose pages are not stated follow each other.
  std::size_t first_page = 0;
  for (std::size_t i = 0; i < chosen; ++i) {
    const auto before = described(*images[i]->child("Pixels"), components, 0, {});
    if (before) first_page += before->pages.size();
  }
  Result<TiffDescription> description =
      described(*images[chosen]->child("Pixels"), components, first_page, std::move(files));
  if (!description) return description;
  description->images = std::move(names);
  description->image = chosen;
  return description;
}

std::optional<TiffDescription> parse_shape(std::string_view text,
                                           std::array<std::int64_t, 2> image_size,
                                           std::int64_t components) {
  if (!trimmed(text).starts_with('{')) return std::nullopt;
  const nlohmann::json json = parse_json(text);
  const auto found = json.is_object() ? json.find("shape") : json.end();
  if (found == json.end() || !found->is_array()) return std::nullopt;
  std::vector<std::int64_t> shape;
  for (const nlohmann::json& size : *found) {
    if (!size.is_number_integer()) return std::nullopt;
    shape.push_back(size.get<std::int64_t>());
    if (shape.back() < 1 || shape.back() > kMaxTiffPages) return std::nullopt;
  }
  std::string axes;
  if (const auto named = json.find("axes"); named != json.end() && named->is_string()) {
    axes = named->get<std::string>();
  }
  if (axes.size() != shape.size()) axes.assign(shape.size(), 'Q');
  const auto ends_with = [&](const std::vector<std::int64_t>& end) {
    return shape.size() >= end.size() && std::equal(end.rbegin(), end.rend(), shape.rbegin());
  };
  const auto [columns, rows] = image_size;
  const bool has_components = components > 1 && (ends_with({rows, columns, components}) ||
                                                 ends_with({components, rows, columns}));
  if (!has_components && !ends_with({rows, columns})) return std::nullopt;
  const std::size_t before = shape.size() - (has_components ? 3 : 2);
  TiffDescription description;
  std::int64_t times = 1;
  for (std::size_t i = 0; i < before; ++i) {
    const bool is_last = i + 1 == before;
    const bool is_slices = axes[i] == 'Z' || (is_last && axes[i] != 'C' && axes[i] != 'T');
    (is_slices ? description.slices : axes[i] == 'C' ? description.channels : times) *= shape[i];
  }
  description.times.count = times;
  // Pages are in the order of the axes, of which the last is the fastest.
  std::string order;
  for (std::size_t i = before; i-- > 0;) {
    const bool is_last = i + 1 == before;
    const char axis = axes[i] == 'C' || axes[i] == 'T' ? axes[i]
                      : axes[i] == 'Z' || is_last      ? 'Z'
                                                       : 'T';
    if (order.find(axis) == std::string::npos) order += axis;
  }
  for (const char axis : {'Z', 'C', 'T'}) {
    if (order.find(axis) == std::string::npos) order += axis;
  }
  if (!order_pages(description, order)) return std::nullopt;
  return description;
}

}  // namespace multitetra
