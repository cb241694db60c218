#include "server/volume/formats/arrays/bdv_description.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "common/base/number_text.hpp"
#include "common/base/vec3.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/numbered_files.hpp"
#include "server/volume/formats/detail/xml_document.hpp"
#include "server/volume/formats/hdf5/hdf5_file.hpp"
#include "server/volume/formats/zarr/zarr_volume.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxXmlBytes = std::size_t{1} << 26;

// Twelve numbers, row by row.
std::optional<Affine> affine_from(const std::string& text) {
  const std::vector<double> numbers = finite_numbers(text);
  if (numbers.size() != 12) return std::nullopt;
  Affine map;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      map.columns[column][row] = numbers[4 * row + column];
    }
    map.translation[row] = numbers[4 * row + 3];
  }
  return map;
}

void add_registrations(const fs::path& file, const XmlElement& xml, BdvDescription& description) {
  for (const XmlElement* const view : xml.all("ViewRegistration")) {
    const auto time = integer(view->attribute("timepoint"));
    const auto setup = integer(view->attribute("setup"));
    if (!time || !setup) continue;
    Affine map;  // The last transform is applied first.
    for (const XmlElement* const transform : view->all("ViewTransform")) {
      const std::optional<Affine> next = affine_from(transform->text_of("affine"));
      if (!next) {
        fail_reading(file,
                     "a ViewTransform of its setup " + std::to_string(*setup) +
                         " is not an affine map of twelve numbers",
                     "Save the registrations again");
      }
      map = composed(map, *next);
    }
    description.registrations[{*time, *setup}] = map;
  }
}

void add_times(const XmlElement& xml, BdvDescription& description) {
  std::set<std::int64_t> times;
  for (const auto& [view, map] : description.registrations) times.insert(view.first);
  for (const XmlElement* const points : xml.all("Timepoints")) {
    const auto first = integer(points->text_of("first"));
    const auto last = integer(points->text_of("last"));
    if (!first || !last || !times.empty()) continue;
    for (std::int64_t t = *first; t <= *last && times.size() < kMaxSourceMembers; ++t) {
      times.insert(t);
    }
  }
  if (times.empty()) times.insert(0);
  description.times.assign(times.begin(), times.end());
}

void add_loader(const XmlElement& xml, BdvDescription& description) {
  const std::vector<const XmlElement*> loaders = xml.all("ImageLoader");
  if (loaders.empty()) return;
  description.format = loaders.front()->attribute("format");
  const std::string kind = description.format.substr(description.format.rfind('.') + 1);
  const XmlElement* const named = loaders.front()->child(kind);
  if (named == nullptr) return;
  const bool is_absolute = named->attribute("type") == "absolute";
  const std::string base = is_absolute ? std::string() : xml.text_of("BasePath");
  description.samples = std::filesystem::path(base) / named->text;
}

// The setup by its number from 1 or its name, or the only one.
const BdvSetup& chosen_setup(const fs::path& file, const BdvDescription& description,
                             const VolumeChoice& choice) {
  const std::vector<BdvSetup>& setups = description.setups;
  const auto number = integer(choice.series);
  if (number && *number >= 1 && *number <= std::ssize(setups)) {
    return setups[static_cast<std::size_t>(*number - 1)];
  }
  for (const BdvSetup& setup : setups) {
    if (!choice.series.empty() && setup.name == choice.series) return setup;
  }
  if (setups.empty()) fail_reading(file, "it has no ViewSetup", "Save it again");
  if (choice.series.empty() && (setups.size() == 1 || choice.first)) return setups.front();
  fail_reading(file,
               "it has " + std::to_string(setups.size()) + " setups" +
                   (choice.series.empty() ? "" : ", but none '" + choice.series + "'"),
               "Choose one with --series, by its number from 1 or its name");
}

std::string padded(std::int64_t number, std::size_t width) {
  const std::string digits = std::to_string(number);
  return std::string(width - std::min(width, digits.size()), '0') + digits;
}

}  // namespace

bool is_bdv_xml(std::string_view beginning) {
  return beginning.starts_with('<') && beginning.find("<SpimData") != std::string_view::npos;
}

BdvDescription bdv_description(const fs::path& file) {
  const Result<XmlElement> xml = parse_xml(InputFile(file).beginning(kMaxXmlBytes));
  if (!xml) fail_reading(file, xml.error().text, "Save it again");
  BdvDescription description;
  for (const XmlElement* const setup : xml->all("ViewSetup")) {
    const auto id = integer(setup->text_of("id"));
    if (!id || description.setups.size() == kMaxSourceMembers) continue;
    BdvSetup& added = description.setups.emplace_back();
    added.id = *id;
    added.name = member_name_from(setup->text_of("name"));
    const XmlElement* const voxel = setup->child("voxelSize");
    if (voxel == nullptr) continue;
    added.voxel = finite_numbers(voxel->text_of("size"));
    if (added.voxel.size() != 3) added.voxel.clear();
    added.unit = voxel->text_of("unit");
  }
  add_registrations(file, *xml, description);
  add_times(*xml, description);
  add_loader(*xml, description);
  return description;
}

std::optional<BdvDescription> bdv_description_beside(const fs::path& file) {
  constexpr std::size_t kBeginning = 4096;
  constexpr int kMaxCandidates = 1000;
  std::error_code error;
  const fs::path samples = fs::weakly_canonical(file, error);
  const fs::path folder = samples.parent_path();
  const fs::path of_same_name = folder / (samples.stem().string() + ".xml");
  int candidates = 0;
  std::vector<fs::path> found = {of_same_name};
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (entry->path().extension() == ".xml" && ++candidates < kMaxCandidates) {
      found.push_back(entry->path());
    }
  }
  std::sort(found.begin() + 1, found.end());
  for (const fs::path& xml : found) {
    if (!fs::is_regular_file(xml, error) || !is_bdv_xml(InputFile(xml).beginning(kBeginning))) {
      continue;
    }
    BdvDescription description = bdv_description(xml);
    if (xml == of_same_name || fs::equivalent(folder / description.samples, samples, error)) {
      return description;
    }
  }
  return std::nullopt;
}

bool place_bdv_view(const BdvDescription& description, std::int64_t time, std::int64_t setup,
                    const std::array<double, 3>& factors, ImageHeader& header) {
  const auto found = std::find_if(description.setups.begin(), description.setups.end(),
                                  [&](const BdvSetup& one) { return one.id == setup; });
  if (found == description.setups.end()) return false;
  const std::vector<double>& voxel = found->voxel;
  const auto registration = description.registrations.find({time, setup});
  const bool is_registered = registration != description.registrations.end();
  if (voxel.empty() && !is_registered) return false;
  Affine map;
  if (is_registered) {
    map = registration->second;
  } else {
    for (std::size_t axis = 0; axis < 3; ++axis) map.columns[axis][axis] = voxel[axis];
  }
  std::string unit = found->unit;
  if (!voxel.empty() && is_registered) {
    // World coordinates are lengths, or, as BigStitcher has it, multiples of one of the sides of a
    // voxel; a registration may stretch a view a little.
    Vec3 ratios;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ratios[axis] = voxel[axis] / length(map.columns[axis]);
    }
    const auto [least, most] = std::minmax_element(ratios.begin(), ratios.end());
    const double ratio = std::cbrt(ratios[0] * ratios[1] * ratios[2]);
    constexpr double kStretch = 1.1;
    if (!(*most <= kStretch * *least)) {
      header.contradictions.push_back(
          {Fact::kSpacing,
           "its registrations give a voxel other proportions than its voxelSize; "
           "the registrations are used, in a unit that is unknown"});
      unit.clear();
    } else if (!(ratio < kStretch && ratio > 1 / kStretch)) {
      for (Vec3& column : map.columns) column = scaled(column, ratio);
      map.translation = scaled(map.translation, ratio);
      header.contradictions.push_back(
          {Fact::kSpacing,
           "its registrations count voxels; their lengths are those of voxelSize, " +
               rounded_text(ratio) + " " + unit});
    }
  }
  std::array<Vec3, 3> steps{};
  Vec3 first{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    steps[axis] = scaled(map.columns[axis], factors[axis]);
    first[axis] = (factors[axis] - 1) / 2;
  }
  set_axes(header, steps, stated(map(first)));
  set_units_of_axes(header, {unit, unit, unit});
  return true;
}

StoredVolume open_bdv(const fs::path& xml, const VolumeChoice& choice) {
  const BdvDescription description = bdv_description(xml);
  const bool is_hdf5 = description.format == "bdv.hdf5";
  if ((!is_hdf5 && description.format != "bdv.n5") || description.samples.empty()) {
    fail_reading(xml, "its images have the format '" + description.format + "', which is not read",
                 "Resave it as HDF5 or N5, or give one of its images");
  }
  VolumeChoice inside = choice;
  inside.time.reset();
  inside.level.reset();
  inside.series.clear();
  inside.described_by = xml;
  const BdvSetup& setup = chosen_setup(xml, description, choice);
  const auto times = std::ssize(description.times);
  const auto time = description.times[static_cast<std::size_t>(chosen_time(xml, times, choice))];
  const std::int64_t level = choice.level.value_or(0);
  if (choice.array.empty()) {
    inside.array = is_hdf5 ? "/t" + padded(time, 5) + "/s" + padded(setup.id, 2) + "/" +
                                 std::to_string(level) + "/cells"
                           : "setup" + std::to_string(setup.id) + "/timepoint" +
                                 std::to_string(time) + "/s" + std::to_string(level);
  }
  const fs::path samples =
      named_data_place(xml, description.samples.string(), choice.allow_external_files);
  StoredVolume volume = is_hdf5 ? open_hdf5(samples, inside) : open_zarr(samples.string(), inside);
  volume.contents.times = {.count = times};
  std::vector<std::string> names;
  for (const BdvSetup& one : description.setups) {
    names.push_back(one.name.empty() ? std::to_string(one.id) : one.name);
  }
  offer_images(xml, "setup", names, choice, volume);
  return volume;
}

}  // namespace multitetra
