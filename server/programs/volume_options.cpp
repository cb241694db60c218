#include "server/programs/volume_options.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <iostream>
#include <mutex>
#include <sstream>
#include <stdexcept>

#include "common/base/exit_codes.hpp"
#include "common/base/number_text.hpp"
#include "common/base/parse_number.hpp"
#include "common/sandbox/sandbox.hpp"

namespace multitetra {

ComponentChoice component_from(const std::string& text) {
  if (const auto chosen = ComponentChoice::from(text)) return *chosen;
  throw ExitError(kUsage, "--component: \"" + text +
                              "\" is invalid; write an index from 0, magnitude or luminance.");
}

std::optional<double> outside_from(const std::string& text) {
  if (text == "void") return std::nullopt;
  try {
    std::size_t used = 0;
    const double value = std::stod(text, &used);
    if (used == text.size() && std::isfinite(value)) return value;
  } catch (const std::exception&) {  // Reported below.
  }
  throw std::invalid_argument("--pad-value: \"" + text +
                              "\" is invalid; write void or a finite number.");
}

void add_border_options(Command& command, std::string& outside, std::optional<int>& margin) {
  command
      .add_option("--pad-value,--outside", outside,
                  "Value of the --pad layers, which close surfaces; void: none, they end at the "
                  "last sample "
                  "(default: void; 0 for labels)")
      ->type_name("VALUE");
  command
      .add_option("--pad,--margin", margin,
                  "Layers of that value around the data (default: 0; 1 for labels)")
      ->within(0, 4096);
}

namespace {

// Parses "64,64,64" or "64x64x64".
std::optional<std::vector<std::int32_t>> dims_from(std::string text) {
  for (char& c : text) {
    if (c == 'x' || c == 'X') c = ',';
  }
  return parse_numbers<std::int32_t>(text, 3);
}

}  // namespace

void VolumeOptions::add_to(Command& command) {
  command.add_option("--array", array,
                     "Array inside the source: a path (Zarr, N5, HDF5) or a name (.vti)");
  command.add_option("--level", level, "OME-Zarr: level of the pyramid, 0 the finest");
  command.add_option("--time", time, "Index of the time, from 0");
  command.add_option("--channel", channel, "Index of the channel, from 0");
  command.add_option("--series", series, "DICOM: UID or number of the series");
  command.add_option("--component", component,
                     "Component of a sample: its index from 0, magnitude, or luminance (RGB)");
  command.add_flag("--follow", allow_external_files,
                   "Read data files outside the folder of the header that refers to them");
  command.add_flag(
      "--resample", resample,
      "Interpolate uneven or tilted slices and sheared grids to an even grid; labels: nearest");
  command.add_option("--subtract", subtract,
                     "Subtract this from all values, in double precision: keeps small differences "
                     "between large values");
  command.add_flag(
      "--allow-loss", allow_loss,
      "Accept samples that lose more than a hundredth of their range as 32-bit floats");
  const auto parse_dims = [this](const std::string& text) -> std::optional<std::string> {
    const auto sides = dims_from(text);
    if (!sides) return "must be three numbers, such as 64,64,32 or 64x64x32";
    dims = *sides;
    return std::nullopt;
  };
  Option* layout =
      command.add_parsed("--dims", parse_dims, "Raw file: samples along x,y,z")->type_name("X,Y,Z");
  const auto parse_type = [this](const std::string& text) -> std::optional<std::string> {
    auto known = stored_type_from(text);
    if (!known) known = stored_type_from_word(text);
    if (!known)
      return "must be u8, i8, u16, i16, f32, u32, i32, u64, i64, f64 or a name such as uint8";
    type = name(*known);
    return std::nullopt;
  };
  command
      .add_parsed("--type", parse_type, "Raw file: type of a sample, such as u8, uint16 or float32")
      ->type_name("TYPE")
      ->default_text(type)
      ->needs(layout);
  command.add_option("--endian", endian, "Raw file: order of bytes")
      ->one_of({"little", "big"})
      ->capture_default_str()
      ->needs(layout);
  command.add_option("--header-bytes", header_bytes, "Raw file: bytes before the first sample")
      ->capture_default_str()
      ->needs(layout);
  command
      .add_option("--spacing", spacing,
                  "World units between samples along x,y,z; replaces those of the file")
      ->delimiter(',')
      ->expected(3)
      ->type_name("X,Y,Z");
  command
      .add_option("--origin", origin,
                  "World coordinates of the first sample; replaces those of the file")
      ->delimiter(',')
      ->expected(3)
      ->type_name("X,Y,Z");
  Option* const orientation =
      command
          .add_option("--orient", orient,
                      "Turn the volume upright: the new directions of its axes x, y and z; x,-y,-z "
                      "turns one that is upside down")
          ->type_name("AXIS,AXIS,AXIS");
  command
      .add_flag("--mirror", mirror,
                "Accept an --orient that exchanges left and right, for a volume that is stored as "
                "its mirror image")
      ->needs(orientation);
  add_isolation_option(command, requires_isolation);
  command
      .add_option("--length-unit", length_unit,
                  "Unit of spacing and coordinates, such as mm or um; replaces that of the file")
      ->type_name("UNIT");
}

void VolumeOptions::add_space_to(Command& command) {
  command
      .add_option("--space", space,
                  "Anatomical axes of the coordinates that the file's header has, instead of those "
                  "that it states; RAS is converted to LPS")
      ->one_of({"LPS", "RAS", "none"});
}

void add_isolation_option(Command& command, bool& is_required) {
  command.add_flag("--require-isolation", is_required,
                   "Refuse to read files without Landlock and seccomp");
}

void apply_isolation_option(bool is_required) {
  static std::once_flag once;
  if (is_required) require_isolation();
  std::call_once(once, [] {
    const Isolation isolation = isolation_of_this_kernel();
    if (isolation.is_complete()) return;
    std::cerr << "isolation: " << text_of(isolation)
              << ". The readers of files are isolated in part; --require-isolation refuses that.\n";
  });
}

std::string VolumeOptions::command_line() const {
  std::ostringstream text;
  const auto add_option_text = [&](const char* name, const auto& value) {
    text << (text.view().empty() ? "" : " ") << name << " " << value;
  };
  if (!array.empty()) add_option_text("--array", array);
  if (level) add_option_text("--level", *level);
  if (time) add_option_text("--time", *time);
  if (channel) add_option_text("--channel", *channel);
  if (!series.empty()) add_option_text("--series", series);
  if (!component.empty()) add_option_text("--component", component);
  if (resample) text << (text.view().empty() ? "" : " ") << "--resample";
  if (subtract != 0) add_option_text("--subtract", shortest_text(subtract));
  if (allow_loss) text << (text.view().empty() ? "" : " ") << "--allow-loss";
  for (const double step : spacing) add_option_text("--spacing", shortest_text(step));
  for (const double place : origin) add_option_text("--origin", shortest_text(place));
  if (!orient.empty()) add_option_text("--orient", orient);
  if (mirror) text << " --mirror";
  if (!space.empty()) add_option_text("--space", space);
  if (!length_unit.empty()) add_option_text("--length-unit", length_unit);
  if (dims.empty()) return text.str();
  for (const std::int32_t side : dims) add_option_text("--dims", side);
  add_option_text("--type", type);
  add_option_text("--endian", endian);
  add_option_text("--header-bytes", header_bytes);
  return text.str();
}

Placement VolumeOptions::placement() const {
  Placement placement;
  if (!spacing.empty()) {
    const auto is_length = [](double step) { return std::isfinite(step) && step > 0; };
    if (!std::all_of(spacing.begin(), spacing.end(), is_length)) {
      throw ExitError(kUsage,
                      "--spacing: the distance between samples must be a number greater than 0.");
    }
    std::copy_n(spacing.begin(), 3, placement.spacing.emplace().begin());
  }
  if (!orient.empty()) {
    placement.orient = axis_directions_from(orient);
    if (!placement.orient) {
      throw ExitError(kUsage, "--orient: \"" + orient +
                                  "\" is invalid; write x, y and z in any order, each with or "
                                  "without a minus, such as x,-z,y.");
    }
    if (is_mirror(*placement.orient) != mirror) {
      throw ExitError(
          kUsage,
          mirror ? "--mirror: --orient " + orient + " turns without mirroring; leave --mirror out."
                 : "--orient " + orient +
                       " mirrors the volume: left and right would be exchanged. To turn it give " +
                       nearest_rotations(*placement.orient) +
                       "; if the volume is stored as its mirror image, add --mirror.");
    }
  }
  if (!origin.empty()) std::copy_n(origin.begin(), 3, placement.origin.emplace().begin());
  if (!space.empty()) placement.space = world_space_from(space == "none" ? "" : space);
  if (!length_unit.empty()) {
    placement.length_unit = unit_from(length_unit);
    if (placement.length_unit->empty()) {
      throw ExitError(kUsage, "--length-unit: \"" + length_unit +
                                  "\"; it must be UTF-8 of at most " +
                                  std::to_string(kMaxUnitBytes) +
                                  " bytes without control characters, such as mm.");
    }
  }
  return placement;
}

VolumeFileOptions VolumeOptions::parsed() const {
  apply_isolation_option(requires_isolation);
  VolumeFileOptions options;
  options.choice = {.array = array,
                    .level = level,
                    .time = time,
                    .channel = channel,
                    .series = series,
                    .component = {},
                    .allow_external_files = allow_external_files,
                    .resample = resample,
                    .subtract = subtract,
                    .allow_loss = allow_loss};
  if (!component.empty()) options.choice.component = component_from(component);
  options.placement = placement();
  if (dims.empty()) return options;
  options.raw = RawLayout{.type = stored_type_from(type).value(),
                          .endian = endian == "big" ? Endian::kBig : Endian::kLittle,
                          .header_bytes = header_bytes};
  std::copy_n(dims.begin(), 3, options.raw->dims.begin());
  return options;
}

}  // namespace multitetra
