#include "server/volume/formats/detail/tiff_description.hpp"

#include <expat.h>

#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include "common/base/parse_number.hpp"
#include "common/base/text.hpp"
#include "server/volume/formats/detail/numbered_files.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {
namespace {

constexpr std::int64_t kMaxTiffPages = std::int64_t{1} << 24;

tl::unexpected<Error> no_description(const std::string& problem) {
  return fail(ErrorCode::kInvalidArgument, problem);
}

using Values = std::map<std::string, std::string, std::less<>>;

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

class OmeParser {
 public:
  OmeParser() : parser_(XML_ParserCreate(nullptr), &XML_ParserFree) {
    XML_SetUserData(parser_.get(), this);
    XML_SetElementHandler(parser_.get(), &on_start, nullptr);
    // Valid files have no entities, and their expansion is unbounded.
    XML_SetEntityDeclHandler(parser_.get(), &on_entity);
  }

  Result<TiffDescription> parse(std::string_view text, std::int64_t components) {
    const auto status =
        XML_Parse(parser_.get(), text.data(), static_cast<int>(text.size()), XML_TRUE);
    if (!failure_.empty()) return no_description(failure_);
    if (status != XML_STATUS_OK) return no_description("the XML of its description is damaged");
    if (pixels_.empty()) return no_description("its description has no Pixels");
    TiffDescription description;
    description.slices = count_of(pixels_, "SizeZ");
    description.channels = count_of(pixels_, "SizeC");
    // A page may contain several channels as components of its samples.
    if (components > 1 && description.channels % components == 0) {
      description.channels /= components;
    }
    description.times =
        even_times(count_of(pixels_, "SizeT"), 0, length_of(pixels_, "TimeIncrement").value_or(0),
                   unit_of("TimeIncrementUnit", "s"));
    std::string order = text_of_value(pixels_, "DimensionOrder");
    if (order.empty()) order = "XYZCT";
    if (!order.starts_with("XY") ||
        !std::ranges::is_permutation(order, std::string_view("XYZCT"))) {
      return no_description("its DimensionOrder is neither XYZCT nor XY with another order of ZCT");
    }
    if (const auto done = order_pages(description, std::string_view(order).substr(2)); !done) {
      return tl::unexpected(done.error());
    }
    if (static_cast<std::int64_t>(channels_.size()) == description.channels) {
      description.described_channels = channels_;
    }
    if (const auto done = place_blocks(description); !done) return tl::unexpected(done.error());
    if (const auto done = set_spacing(description); !done) return tl::unexpected(done.error());
    return description;
  }

 private:
  static void XMLCALL on_start(void* self, const XML_Char* name, const XML_Char** attributes) {
    Values values;
    for (const XML_Char** at = attributes; *at != nullptr; at += 2) values[at[0]] = at[1];
    static_cast<OmeParser*>(self)->start(name, std::move(values));
  }
  static void XMLCALL on_entity(void* self, const XML_Char*, int, const XML_Char*, int,
                                const XML_Char*, const XML_Char*, const XML_Char*,
                                const XML_Char*) {
    static_cast<OmeParser*>(self)->stop(
        "its description declares XML entities, which are not allowed");
  }

  void stop(const char* failure) {
    failure_ = failure;
    XML_StopParser(parser_.get(), XML_FALSE);
  }

  // Returns the attribute Color: a signed number whose bytes are red, green, blue and alpha.
  static std::optional<std::uint32_t> ome_color(const Values& values) {
    const auto rgba = parse_number<std::int32_t>(text_of_value(values, "Color"));
    return rgba ? std::optional(static_cast<std::uint32_t>(*rgba) >> 8) : std::nullopt;
  }

  void start(std::string_view name, Values values) {
    name.remove_prefix(std::min(name.find(':') + 1, name.size()));  // "OME:Pixels"
    if (name == "Image") ++images_;
    if (images_ > 1) return;  // Images after the first are labels and overviews.
    if (name == "Pixels") pixels_ = std::move(values);
    if (name == "Channel") {
      channels_.push_back({.name = text_of_value(values, "Name"), .color = ome_color(values)});
    }
    if (name == "TiffData") blocks_.push_back(std::move(values));
    if (name == "UUID" && values.contains("FileName")) {
      if (file_name_.empty()) file_name_ = values["FileName"];
      if (file_name_ != values["FileName"])
        stop("its pages are in several files, which is not supported");
    }
  }

  [[nodiscard]] std::string unit_of(std::string_view name, const std::string& otherwise) const {
    const std::string unit = text_of_value(pixels_, name);
    return unit.empty() ? otherwise : unit;
  }

  // Places the blocks of pages that specify their first page.
  Result<void> place_blocks(TiffDescription& description) const {
    const std::vector<std::size_t> ordered = description.pages;
    // Position of each page in the order.
    std::vector<std::size_t> place_of(ordered.size());
    for (std::size_t i = 0; i < ordered.size(); ++i) place_of[ordered[i]] = i;
    for (const Values& block : blocks_) {
      if (!block.contains("IFD")) continue;
      const std::int64_t z = count_of_first(block, "FirstZ");
      const std::int64_t c = count_of_first(block, "FirstC");
      const std::int64_t t = count_of_first(block, "FirstT");
      const std::int64_t page = count_of_first(block, "IFD");
      const std::int64_t count = block.contains("PlaneCount") ? count_of(block, "PlaneCount") : 1;
      if (z < 0 || z >= description.slices || c < 0 || c >= description.channels || t < 0 ||
          t >= description.times.count || page < 0 || page > kMaxTiffPages) {
        return no_description("its description has pages of slices that do not exist");
      }
      const auto first =
          static_cast<std::size_t>((t * description.channels + c) * description.slices + z);
      // The block continues in the order of pages.
      for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
        if (ordered[first] + i >= ordered.size()) break;
        description.pages[place_of[ordered[first] + i]] = static_cast<std::size_t>(page) + i;
      }
    }
    return {};
  }

  static std::int64_t count_of_first(const Values& values, std::string_view name) {
    const std::string text = text_of_value(values, name);
    return text.empty() ? 0 : integer(text).value_or(-1);
  }

  Result<void> set_spacing(TiffDescription& description) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string name = std::string("PhysicalSize") + "XYZ"[axis];
      description.spacing[axis] = length_of(pixels_, name);
      if (!description.spacing[axis]) continue;
      const std::string unit = unit_from(unit_of(name + "Unit", "µm"));
      if (!description.length_unit.empty() && description.length_unit != unit) {
        return no_description("its axes have different units, " + description.length_unit +
                              " and " + unit);
      }
      description.length_unit = unit;
    }
    return {};
  }

  std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser_;
  std::string failure_;
  int images_ = 0;
  Values pixels_;
  std::vector<TiffChannel> channels_;
  std::vector<Values> blocks_;
  std::string file_name_;
};

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
  description.length_unit = imagej_unit(text_of_value(values, "unit"));
  description.resolution_is_spacing = true;
  description.spacing[2] = length_of(values, "spacing");
  if (const auto done = order_pages(description, "CZT"); !done) return tl::unexpected(done.error());
  return description;
}

Result<TiffDescription> parse_ome_description(std::string_view text, std::int64_t components) {
  return OmeParser().parse(text, components);
}

}  // namespace multitetra
