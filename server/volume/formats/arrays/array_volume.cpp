#include "server/volume/formats/arrays/array_volume.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "server/volume/formats/detail/plain_slices.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

double samples_of(const std::vector<std::int64_t>& shape) {
  double product = 1;
  for (const std::int64_t side : shape) product *= static_cast<double>(side);
  return product;
}

std::string shape_text(const std::vector<std::int64_t>& shape) {
  std::string text;
  for (auto side = shape.rbegin(); side != shape.rend(); ++side) {
    text += (text.empty() ? "" : " x ") + std::to_string(*side);
  }
  return text;
}

// "axis 1 (time)", counted in the order of the file.
std::string dimension_text(const ArrayContainer& file, const std::string& array, std::size_t d) {
  const std::vector<std::string> names = file.dimension_names(array);
  const bool is_named = d < names.size() && !names[d].empty();
  return "its dimension " + std::to_string(d + 1) + (is_named ? " (" + names[d] + ")" : "");
}

// Makes the first dimension of unknown role the time, the next one the channel.
void settle_roles(const std::vector<std::int64_t>& shape, const VolumeChoice& choice,
                  ArrayMeaning& meaning) {
  std::vector<DimensionRole>& roles = meaning.roles;
  const auto has = [&](DimensionRole role) {
    return std::find(roles.begin(), roles.end(), role) != roles.end();
  };
  for (std::size_t d = 0; d < roles.size(); ++d) {
    if (roles[d] != DimensionRole::kOther || shape[d] == 1) continue;
    if (!has(DimensionRole::kTime)) {
      roles[d] = DimensionRole::kTime;
    } else if (!has(DimensionRole::kChannel)) {
      roles[d] = DimensionRole::kChannel;
    }
  }
  const bool are_channels =
      meaning.are_roles_by_place && choice.channel && !choice.time && !has(DimensionRole::kChannel);
  if (are_channels)
    std::replace(roles.begin(), roles.end(), DimensionRole::kTime, DimensionRole::kChannel);
}

// Sets the position along the dimensions that are no axes.
void choose_entries(const ArrayContainer& file, const std::string& array,
                    const std::vector<std::int64_t>& shape, const ArrayMeaning& meaning,
                    const VolumeChoice& choice, VolumeInArray& place, StoredVolume& volume) {
  for (std::size_t d = 0; d < shape.size(); ++d) {
    const DimensionRole role = meaning.roles[d];
    if (role <= DimensionRole::kZ || place.component == d) continue;
    const bool is_time = role == DimensionRole::kTime;
    const bool is_channel = role == DimensionRole::kChannel;
    if (is_time) {
      volume.contents.times = meaning.times;
      volume.contents.times.count = shape[d];
    }
    if (is_channel) volume.channels = shape[d];
    const std::string dimension = dimension_text(file, array, d);
    const FileEntries entries = {
        .count = shape[d],
        .several = dimension + " has " + std::to_string(shape[d]) + " entries",
        .remedy = is_time      ? kChooseTime
                  : is_channel ? kChooseChannel
                               : "Give an array of at most five dimensions",
        .missing = dimension + " has no entry"};
    const std::optional<std::int64_t> chosen = is_time      ? choice.time
                                               : is_channel ? choice.channel
                                                            : std::nullopt;
    place.at[d] =
        chosen_entry(file.file(), entries, chosen, choice.first && (is_time || is_channel));
  }
}

void set_dims(const fs::path& path, const std::string& array,
              const std::vector<std::int64_t>& shape, const VolumeInArray& place,
              ImageHeader& header) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!place.axes[axis]) continue;
    header.dims[axis] = shape[*place.axes[axis]];
    if (header.dims[axis] <= kMaxSide) continue;
    fail_reading(path,
                 "a side of '" + array + "' has " + std::to_string(header.dims[axis]) + " samples",
                 "Each side must have 1 to " + std::to_string(kMaxSide) + " samples");
  }
  if (place.component) header.components = shape[*place.component];
}

// Slices of an array in any order of its dimensions.
class ArraySlices : public StoredSlices {
 public:
  ArraySlices(std::unique_ptr<ArrayReader> reader, std::vector<std::int64_t> shape,
              VolumeInArray place)
      : reader_(std::move(reader)),
        shape_(std::move(shape)),
        width_(bytes_of(place.type)),
        place_(std::move(place)) {
    // The volume's dimensions, fastest first: numbers of a sample, x, y, z.
    for (const auto& d : {place_.component, place_.axes[0], place_.axes[1], place_.axes[2]}) {
      if (d) order_.push_back(*d);
    }
    is_in_order_ = std::is_sorted(order_.rbegin(), order_.rend());
    if (!is_in_order_ && place_.axes[2]) {
      constexpr std::size_t kBlockBytes = std::size_t{1} << 28;
      block_ =
          std::clamp<std::size_t>(kBlockBytes / std::max<std::size_t>(slice_bytes(), 1), 1, 64);
    }
  }

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    if (is_in_order_) return read_box(first, count, into);
    for (std::size_t z = first; z < first + count; ++z, into += slice_bytes()) {
      if (z < begin_ || z >= end_) fetch(z);
      const std::byte* const slice = transposed_.data() + (z - begin_) * slice_bytes();
      std::copy_n(slice, slice_bytes(), into);
    }
  }

  [[nodiscard]] std::vector<std::string> findings() const override {
    return has_unwritten_ ? std::vector{place_.unwritten_notice} : std::vector<std::string>();
  }

 private:
  [[nodiscard]] std::size_t side(std::size_t d) const {
    return static_cast<std::size_t>(shape_[d]);
  }

  [[nodiscard]] std::size_t slice_bytes() const {
    std::size_t bytes = width_;
    for (const std::size_t d : order_) bytes *= d == place_.axes[2] ? 1 : side(d);
    return bytes;
  }

  void read_box(std::size_t first, std::size_t count, std::byte* into) {
    std::vector<std::int64_t> start = place_.at;
    std::vector<std::int64_t> extent(shape_.size(), 1);
    for (const std::size_t d : order_) {
      start[d] = 0;
      extent[d] = shape_[d];
    }
    if (const auto z = place_.axes[2]) {
      start[*z] = static_cast<std::int64_t>(first);
      extent[*z] = static_cast<std::int64_t>(count);
    }
    reader_->read(start, extent, into);
    const std::size_t bytes = place_.unwritten && !has_unwritten_ ? count * slice_bytes() : 0;
    for (std::size_t at = 0; at < bytes; at += width_) {
      has_unwritten_ |= number_from(place_.type, into + at) == *place_.unwritten;
    }
  }

  // Reads a block of slices from `first` on and transposes it.
  void fetch(std::size_t first) {
    const std::size_t slices = place_.axes[2] ? side(*place_.axes[2]) : 1;
    const std::size_t count = std::min(block_, slices - first);
    std::vector<std::byte> stored(count * slice_bytes());
    read_box(first, count, stored.data());
    transposed_.resize(stored.size());
    // Bytes between the entries of each dimension in the file, counted in `stored`.
    const auto length = [&](std::size_t d) { return d == place_.axes[2] ? count : side(d); };
    std::vector<std::size_t> by_place = order_;
    std::sort(by_place.rbegin(), by_place.rend());
    std::map<std::size_t, std::size_t> strides;
    std::size_t stride = width_;
    for (const std::size_t d : by_place) {
      strides[d] = stride;
      stride *= length(d);
    }
    std::vector<std::size_t> at(order_.size(), 0);
    std::size_t from = 0;
    for (std::size_t to = 0; to < transposed_.size(); to += width_) {
      std::copy_n(stored.data() + from, width_, transposed_.data() + to);
      for (std::size_t i = 0; i < order_.size(); ++i) {
        from += strides[order_[i]];
        if (++at[i] < length(order_[i])) break;
        from -= strides[order_[i]] * at[i];
        at[i] = 0;
      }
    }
    begin_ = first;
    end_ = first + count;
  }

  std::unique_ptr<ArrayReader> reader_;
  std::vector<std::int64_t> shape_;
  std::size_t width_;  // Bytes of a number.
  VolumeInArray place_;
  std::vector<std::size_t> order_;
  bool is_in_order_ = true;
  bool has_unwritten_ = false;
  std::size_t block_ = 1;  // Slices that are read at a time.
  std::vector<std::byte> transposed_;
  std::size_t begin_ = 0;  // Its slices.
  std::size_t end_ = 0;
};

// Returns the scale of each slice, from one for each entry of the first dimensions.
std::vector<std::array<double, 2>> scales_of_slices(
    const fs::path& path, const std::vector<std::int64_t>& shape,
    const std::vector<std::array<double, 2>>& scales, const VolumeInArray& place) {
  std::size_t leading = 0;
  for (std::int64_t entries = 1; entries < std::ssize(scales) && leading < shape.size();
       ++leading) {
    entries *= shape[leading];
    const bool is_within_slice = leading == place.axes[0] || leading == place.axes[1];
    if (entries > std::ssize(scales) || is_within_slice) {
      fail_reading(path, "its " + std::to_string(scales.size()) + " scales are not those of slices",
                   "Convert it to values of 32 or 64 bits");
    }
  }
  std::vector<std::array<double, 2>> of_slices;
  for (std::int64_t z = 0; z < (place.axes[2] ? shape[*place.axes[2]] : 1); ++z) {
    std::int64_t entry = 0;
    for (std::size_t d = 0; d < leading; ++d) {
      entry = entry * shape[d] + (d == place.axes[2] ? z : place.at[d]);
    }
    of_slices.push_back(scales.at(static_cast<std::size_t>(entry)));
  }
  return of_slices;
}

}  // namespace

std::string chosen_array(const ArrayContainer& file, const VolumeChoice& choice) {
  if (!choice.array.empty())
    return choice.array.starts_with('/') ? choice.array : "/" + choice.array;
  const std::vector<std::string> found = offered_arrays(file, choice);
  if (found.size() == 1) return found.front();
  const auto largest =
      std::max_element(found.begin(), found.end(), [&](const auto& a, const auto& b) {
        return samples_of(file.shape(a)) < samples_of(file.shape(b));
      });
  if (choice.first && !found.empty()) return *largest;
  std::string list;
  for (const std::string& name : found) {
    if (list.size() < 600) list += (list.empty() ? "" : ", ") + name;
  }
  const std::string example = "'" + file.file().filename().string() + ":/path'";
  if (found.empty()) {
    for (const std::string& name : file.children("")) {
      if (list.size() < 600) list += (list.empty() ? "; it holds " : ", ") + name;
    }
    fail_reading(file.file(),
                 "it has no array of integers or floats with two or more dimensions" + list,
                 "If one of these leads to another file, give its path, as in " + example);
  }
  const auto alike = std::count_if(found.begin(), found.end(), [&](const std::string& name) {
    return file.shape(name) == file.shape(*largest);
  });
  fail_reading(file.file(), "it has " + std::to_string(found.size()) + " arrays: " + list,
               "Choose one with --array, or as in " + example +
                   (alike > 1 ? ", or prepare several of one shape with --field" : ""));
}

StoredVolume described_volume(const ArrayContainer& file, const std::string& array,
                              ArrayMeaning meaning, const VolumeChoice& choice, bool has_components,
                              VolumeInArray& place) {
  const fs::path path = file.file();
  const std::vector<std::int64_t> shape = file.shape(array);
  const std::optional<StoredType> type = file.type(array);
  if (!type || shape.size() < 2 || shape.size() > 8) {
    fail_reading(path,
                 "its '" + array + "' is not an array of integers or floats with 2 to 5 dimensions",
                 "Choose another array");
  }
  if (meaning.roles.size() != shape.size()) meaning.roles = roles_by_place(shape);
  settle_roles(shape, choice, meaning);
  place = {.axes = {}, .at = std::vector<std::int64_t>(shape.size(), 0)};
  for (std::size_t d = 0; d < shape.size(); ++d) {
    DimensionRole& role = meaning.roles[d];
    if (role <= DimensionRole::kZ) place.axes[static_cast<std::size_t>(role)] = d;
    if (role == DimensionRole::kComponent && has_components) place.component = d;
    if (role == DimensionRole::kComponent && !has_components) role = DimensionRole::kChannel;
  }
  StoredVolume volume{.header = std::move(meaning.header)};
  ImageHeader& header = volume.header;
  header.type = meaning.is_unsigned ? unsigned_type(*type) : *type;
  set_dims(path, array, shape, place, header);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    header.dims[axis] = meaning.sides[axis].value_or(header.dims[axis]);
  }
  if (choice.array.empty()) {  // Else this is one of them.
    volume.contents.times.count = meaning.times.count;
    volume.channels = std::max<std::int64_t>(1, std::ssize(meaning.channels));
    volume.contents.fields = std::move(meaning.channels);
  }
  if (meaning.is_geometry_unread && !choice.given.spacing) {
    volume.notices.push_back("'" + path.string() + "': this is " + meaning.name +
                             "; its geometry is not read. Give it with --spacing and --origin.");
  }
  if (meaning.scales.size() == 1) {
    header.slope = meaning.scales[0][0];
    header.intercept = meaning.scales[0][1];
  }
  place.type = header.type;
  check_header(path, header);
  choose_entries(file, array, shape, meaning, choice, place, volume);
  if (meaning.scales.size() > 1) {
    place.scales = scales_of_slices(path, shape, meaning.scales, place);
    header.type = StoredType::kF32;
  }
  return volume;
}

std::unique_ptr<StoredSlices> array_slices(std::unique_ptr<ArrayReader> reader,
                                           std::vector<std::int64_t> shape, VolumeInArray place) {
  const std::vector<std::array<double, 2>> scales = place.scales;
  const StoredType type = place.type;
  std::size_t numbers = 1;
  for (const auto& d : {place.axes[0], place.axes[1], place.component}) {
    if (d) numbers *= static_cast<std::size_t>(shape[*d]);
  }
  auto slices =
      std::make_unique<ArraySlices>(std::move(reader), std::move(shape), std::move(place));
  if (scales.empty()) return slices;
  return scaled_slices(std::move(slices), type, numbers, scales);
}

void list_arrays(const ArrayContainer& file, const std::string& array, VolumeContents& contents) {
  const std::vector<std::int64_t> shape = file.shape(array);
  std::vector<std::string> names = file.arrays();
  if (names.size() < 2) return;
  std::sort(names.begin(), names.end());
  names.resize(std::min(names.size(), kMaxSourceMembers));
  const auto last_part = [](const std::string& name) { return name.substr(name.rfind('/') + 1); };
  const bool has_channels = !contents.fields.empty();  // The arrays of which are these.
  std::map<std::string, int> uses;
  for (const std::string& name : names) uses[last_part(name)] += file.shape(name) == shape;
  for (const std::string& name : names) {
    contents.entries.push_back({.kind = "array",
                                .name = name,
                                .detail = shape_text(file.shape(name)),
                                .option = "--array " + name});
    if (file.shape(name) != shape || has_channels) continue;
    const std::string last = last_part(name);
    const std::string field = member_name_from(uses[last] == 1 ? last : name.substr(1));
    if (field.empty()) {
      contents.unnamed.push_back(name);
    } else {
      contents.fields.push_back({.name = field, .array = name});
    }
  }
}

}  // namespace multitetra
